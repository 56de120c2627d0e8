//! Surfaces in pieces: the same files as from the whole ones, and nothing if something fails.

use crate::{
    MeshContext, MeshSpool, SpoolSink, SurfaceHead, WriteError, WriteFault, Written,
    mesh::kit::{context, surface, torus},
    write_mesh,
};
use isokit_job::Job;
use isokit_mesh::{Counts, MeshSink, Positions, PositionsMut, Precision, Rgba, Surface, TriMesh};
use proptest::{collection::vec, prelude::*, sample::Index};
use std::{fs, ops::Range, path::Path};

const ENDINGS: [&str; 5] = ["ply", "stl", "obj", "glb", "gltf"];

/// Where a surface is cut: the vertices and triangles of each piece.
type Cuts = Vec<(Range<usize>, Range<usize>)>;

fn heads(surfaces: &[Surface]) -> Vec<SurfaceHead> {
    surfaces.iter().map(SurfaceHead::from).collect()
}

/// Hands over a piece of a mesh.
fn give<S: MeshSink>(
    sink: &mut S,
    mesh: &TriMesh,
    (vertices, triangles): &(Range<usize>, Range<usize>),
) -> Result<(), S::Error> {
    let counts = Counts { vertices: vertices.len() as u64, triangles: triangles.len() as u64 };
    let piece = sink.piece(counts, mesh.positions.precision())?;
    match (piece.positions, &mesh.positions) {
        (PositionsMut::F32(room), Positions::F32(all)) => {
            room.copy_from_slice(&all[vertices.clone()]);
        }
        (PositionsMut::F64(room), Positions::F64(all)) => {
            room.copy_from_slice(&all[vertices.clone()]);
        }
        _ => panic!("room of another precision"),
    }
    if let Some(room) = piece.normals {
        room.copy_from_slice(&mesh.normals.as_ref().unwrap()[vertices.clone()]);
    }
    piece.triangles.copy_from_slice(&mesh.triangles[triangles.clone()]);
    Ok(())
}

/// Writes surfaces whose pieces come in turns.
fn spool(
    path: &Path,
    surfaces: &[Surface],
    cuts: &[Cuts],
    context: &MeshContext,
) -> Result<Written, WriteError> {
    let normals = surfaces.iter().any(|surface| surface.mesh.normals.is_some());
    let mut spool = MeshSpool::create(path, heads(surfaces), normals, context, &Job::default())?;
    for turn in 0..cuts.iter().map(Vec::len).max().unwrap_or(0) {
        for (n, (surface, cuts)) in surfaces.iter().zip(cuts).enumerate() {
            if let Some(cut) = cuts.get(turn) {
                give(&mut spool.sink(n), &surface.mesh, cut)?;
            }
        }
    }
    spool.finish()
}

/// The names and bytes of all files in a folder.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let read = |file: fs::DirEntry| {
        (file.file_name().into_string().unwrap(), fs::read(file.path()).unwrap())
    };
    let mut all: Vec<_> = files.map(read).collect();
    all.sort();
    all
}

/// Fails unless pieces make the files and the report, or the error, that the whole surfaces make.
#[track_caller]
fn check(surfaces: &[Surface], cuts: &[Cuts], context: &MeshContext) {
    for ending in ENDINGS {
        let [whole, pieces] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let place = |folder: &tempfile::TempDir| folder.path().join(format!("a b.{ending}"));
        let expected = write_mesh(&place(&whole), surfaces, context, &Job::default());
        let found = spool(&place(&pieces), surfaces, cuts, context);
        match (expected, found) {
            (Ok(expected), Ok(mut found)) => {
                for path in &mut found.files {
                    *path = whole.path().join(path.file_name().unwrap());
                }
                assert_eq!(found, expected, "{ending}");
            }
            (Err(expected), Err(found)) => {
                assert_eq!(found.fault.to_string(), expected.fault.to_string(), "{ending}");
            }
            (expected, found) => panic!("{ending}: {found:?} is not {expected:?}"),
        }
        assert!(contents(pieces.path()) == contents(whole.path()), "{ending}: other bytes");
    }
}

/// One cut, of everything.
fn uncut(surface: &Surface) -> Cuts {
    let Counts { vertices, triangles } = surface.mesh.counts();
    vec![(0..vertices as usize, 0..triangles as usize)]
}

/// The range between neighbours of some marks.
fn ranges(mut marks: Vec<usize>, count: usize) -> Vec<Range<usize>> {
    marks.extend([0, count]);
    marks.sort_unstable();
    marks.windows(2).map(|pair| pair[0]..pair[1]).collect()
}

/// Positions of which some are near enough to be one in f32, within a piece or two neighbours.
fn positions(pieces: &[Range<usize>], steps: &[[u8; 3]], precision: Precision) -> Positions {
    let full = pieces.iter().filter(|piece| !piece.is_empty()).enumerate();
    let far = |turn: usize| 2e6 + 10.0 * (turn / 2) as f64;
    let place = |turn, vertex: usize| steps[vertex].map(|step| far(turn) + f64::from(step) * 0.03);
    let all = full.flat_map(|(turn, piece)| piece.clone().map(move |vertex| place(turn, vertex)));
    match precision {
        Precision::F64 => Positions::F64(all.collect()),
        Precision::F32 => Positions::F32(all.map(|xyz| xyz.map(|c| (c - 2e6) as f32)).collect()),
    }
}

prop_compose! {
    /// A mesh in pieces whose triangles name vertices of their piece and its neighbours.
    fn pieces(precision: Precision, has_normals: bool)(
        steps in vec(prop::array::uniform3(0_u8..5), 0..40),
        marks in vec(any::<Index>(), 0..6),
        corners in vec((any::<Index>(), prop::array::uniform3(any::<Index>())), 0..40),
        normals in vec(prop::array::uniform3(-1.0_f32..1.0), 40),
        flat in prop::option::weighted(0.1, 0_usize..40),
    ) -> (TriMesh, Cuts) {
        let count = steps.len();
        let of = ranges(marks.iter().map(|mark| mark.index(count + 1)).collect(), count);
        let mut by_piece = vec![vec![]; of.len()];
        for (piece, corners) in corners {
            let piece = piece.index(of.len());
            let full = |range: &&Range<usize>| !range.is_empty();
            let before = of[..piece].iter().rfind(full).map_or(0, |range| range.start);
            let behind = of[piece + 1..].iter().find(full).map_or(of[piece].end, |range| range.end);
            if before < behind {
                let corner = |c: Index| (before + c.index(behind - before)) as u32;
                by_piece[piece].push(corners.map(corner));
            }
        }
        let mut end = 0;
        let triangles = by_piece.iter().map(|all| { end += all.len(); end - all.len()..end });
        let cuts = of.iter().cloned().zip(triangles).collect();
        let mut normals = normals[..count].to_vec();
        if let Some(normal) = flat.and_then(|flat| normals.get_mut(flat)) {
            *normal = [0.0; 3];
        }
        let positions = positions(&of, &steps, precision);
        let normals = has_normals.then_some(normals);
        (TriMesh { positions, normals, triangles: by_piece.concat(), ..TriMesh::default() }, cuts)
    }
}

/// Surfaces of one kind, each with its cuts.
fn surfaces() -> impl Strategy<Value = Vec<(Surface, Cuts)>> {
    let precision = prop::sample::select(vec![Precision::F32, Precision::F64]);
    (precision, any::<bool>()).prop_flat_map(|(precision, has_normals)| {
        let head = (any::<String>(), any::<Option<[u8; 4]>>(), any::<Option<i16>>());
        let one = (head, pieces(precision, has_normals));
        let named = one.prop_map(|((name, color, iso), (mesh, cuts))| {
            let (color, iso) = (color.map(Rgba), iso.map(f64::from));
            (Surface { name, color, iso, mesh }, cuts)
        });
        vec(named, 1..4)
    })
}

proptest! {
    #[test]
    fn pieces_of_chance_make_the_files_of_the_whole(surfaces in surfaces()) {
        let (surfaces, cuts): (Vec<_>, Vec<_>) = surfaces.into_iter().unzip();
        check(&surfaces, &cuts, &context());
    }
}

#[test]
fn a_torus_in_slices_makes_the_files_of_the_whole() {
    // More triangles than are read back at a time.
    let n = 190_usize;
    let cuts: Cuts = (0..n).map(|i| (i * n..(i + 1) * n, 2 * i * n..2 * (i + 1) * n)).collect();
    let mut torus = surface(n as u32);
    // The last slice closes to the first one, of which STL then knows nothing.
    torus.mesh.triangles.truncate(2 * n * (n - 1));
    let cuts = vec![[&cuts[..n - 1], &[(n * (n - 1)..n * n, 0..0)]].concat(); 2];
    check(&[torus.clone(), torus], &cuts, &context());
}

#[test]
fn no_surface_and_empty_ones_are_files_all_the_same() {
    check(&[], &[], &context());
    let none = Surface { name: "none".into(), ..Surface::default() };
    check(&[none.clone(), none], &[vec![], vec![(0..0, 0..0)]], &context());
}

#[test]
fn what_the_whole_surface_may_not_be_its_pieces_may_not_be() {
    let mut unsound = surface(4);
    unsound.mesh.triangles[3] = [0, 1, 99];
    check(std::slice::from_ref(&unsound), &[uncut(&unsound)], &context());
    let mut far = surface(4);
    far.mesh.positions = Positions::F64(vec![[f64::MAX; 3]; 16]);
    let cuts = vec![vec![(0..7, 0..0), (7..16, 0..32)]];
    check(&[far], &cuts, &context());
}

#[test]
fn stl_forgets_what_is_older_than_the_piece_before() {
    let (folder, surface) = (tempfile::tempdir().unwrap(), surface(4));
    let cuts = vec![vec![(0..4, 0..0), (4..8, 0..0), (8..12, 0..0), (12..16, 0..32)]];
    let path = folder.path().join("a.stl");
    let error = spool(&path, std::slice::from_ref(&surface), &cuts, &context()).unwrap_err();
    let error = error.fault.to_string();
    let expected = r#"surface "skin": a triangle names vertex 0 where only 8 to 15 are in memory"#;
    assert!(error.starts_with(expected), "{error}");
    assert_eq!(contents(folder.path()), []);
}

#[test]
fn a_spool_that_is_dropped_or_cancelled_leaves_what_was_there() {
    let surfaces = [surface(6), Surface { mesh: torus(5), ..Surface::default() }];
    for ending in ENDINGS {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("a.{ending}"));
        fs::write(&path, "old").unwrap();
        let old = contents(folder.path());
        for (is_cancelled, is_finished) in [(false, false), (true, false), (true, true)] {
            let job = Job::default();
            let spool = MeshSpool::create(&path, heads(&surfaces), true, &context(), &job);
            let mut spool = spool.unwrap();
            for (n, surface) in surfaces.iter().enumerate() {
                give(&mut spool.sink(n), &surface.mesh, &uncut(surface)[0]).unwrap();
            }
            if is_cancelled {
                job.cancel.cancel();
                let again = spool.sink(0).piece(Counts::default(), Precision::F32).map(drop);
                assert!(matches!(again.unwrap_err().fault, WriteFault::Cancelled(_)), "{ending}");
            }
            if is_finished {
                assert!(spool.finish().is_err(), "{ending}: a piece is lost");
            } else {
                drop(spool);
            }
            assert_eq!(contents(folder.path()), old, "{ending}");
        }
    }
}

#[test]
fn nothing_has_a_name_before_all_is_whole() {
    for ending in ENDINGS {
        let folder = tempfile::tempdir().unwrap();
        let (surface, path) = (surface(6), folder.path().join(format!("a.{ending}")));
        let heads = vec![SurfaceHead::from(&surface)];
        let mut spool = MeshSpool::create(&path, heads, true, &context(), &Job::default()).unwrap();
        for cut in [&uncut(&surface)[0], &(0..0, 0..0)] {
            give(&mut spool.sink(0), &surface.mesh, cut).unwrap();
        }
        let is_hidden = |(name, _): &(String, Vec<u8>)| name.starts_with('.');
        assert!(contents(folder.path()).iter().all(is_hidden), "{ending}");
        let written = spool.finish().unwrap();
        assert_eq!(contents(folder.path()).len(), written.files.len(), "{ending}");
    }
}

#[test]
fn more_vertices_than_32_bits_number_are_refused_before_there_is_room_for_them() {
    let folder = tempfile::tempdir().unwrap();
    let counts = Counts { vertices: 1 << 32, triangles: 0 };
    for ending in ENDINGS {
        let path = folder.path().join(format!("a.{ending}"));
        let heads = vec![SurfaceHead::default()];
        let mut spool = MeshSpool::create(&path, heads, true, &context(), &Job::default()).unwrap();
        let error = spool.sink(0).piece(counts, Precision::F32).unwrap_err().to_string();
        assert!(error.contains("holds at most 4294967295 vertices of a surface"), "{error}");
        assert!(error.ends_with("extract it in parts"), "{error}");
        let error = spool.sink(1).piece(Counts::default(), Precision::F32).unwrap_err();
        assert!(matches!(error.fault, WriteFault::Caller(_)), "{error}");
    }
}

#[test]
fn glb_and_stl_are_refused_as_soon_as_they_are_too_large() {
    let folder = tempfile::tempdir().unwrap();
    for (ending, triangles) in [("glb", (1 << 32) / 12), ("stl", 1 << 32)] {
        let path = folder.path().join(format!("a.{ending}"));
        let job = Job::default();
        let mut spool =
            MeshSpool::create(&path, vec![SurfaceHead::default()], true, &context(), &job).unwrap();
        let counts = Counts { vertices: 3, triangles };
        let error = spool.sink(0).piece(counts, Precision::F32).unwrap_err();
        assert!(matches!(error.fault, WriteFault::TooLarge { .. }), "{error}");
    }
}

#[test]
fn pieces_are_of_one_precision() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ply");
    let heads = vec![SurfaceHead { name: "a".into(), ..SurfaceHead::default() }];
    let mut spool = MeshSpool::create(&path, heads, true, &context(), &Job::default()).unwrap();
    spool.sink(0).piece(Counts::default(), Precision::F32).unwrap();
    let error = spool.sink(0).piece(Counts::default(), Precision::F64).unwrap_err();
    assert_eq!(error.fault.to_string(), r#"surface "a": its pieces differ in precision"#);
}

#[test]
fn a_sink_may_be_handed_to_another_thread() {
    fn is_send<T: Send>() {}
    is_send::<SpoolSink<'_>>();
    is_send::<WriteError>();
}

#[test]
fn stl_wants_no_normals() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ENDINGS {
        let path = folder.path().join(format!("a.{ending}"));
        let heads = vec![SurfaceHead::default()];
        let mut spool = MeshSpool::create(&path, heads, true, &context(), &Job::default()).unwrap();
        assert_eq!(spool.sink(0).wants_normals(), ending != "stl");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let surface = surface(6);
    for ending in ENDINGS {
        let path = folder.path().join(format!("a.{ending}"));
        std::os::unix::fs::symlink("/dev/full", &path).unwrap();
        let error = spool(&path, std::slice::from_ref(&surface), &[uncut(&surface)], &context());
        assert!(matches!(error.unwrap_err().fault, WriteFault::Io(_)), "{ending}");
    }
    let count = fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(count, ENDINGS.len(), "no materials without an object, no buffer without a scene");
}
