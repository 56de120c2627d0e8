//! fidget as a contender of `scripts/bench_fields`: a listing of steps becomes a mesh, on the clock.
//!
//! Requests and answers are JSON, one object a line, on stdin and stdout. Reading the listing, which makes an expression
//! of it, is outside of all times; making machine code of the expression is not.

use fidget::{
    context::Context,
    jit::JitShape,
    mesh::{Mesh, Octree, Settings},
    render::{CancelToken, ThreadPool},
};
use nalgebra::{Matrix4, Vector3};
use serde::{Deserialize, Serialize};
use std::{
    fs::File,
    io::{BufRead, BufWriter, Write, stdin, stdout},
    path::{Path, PathBuf},
    time::Instant,
};

type Failure = Box<dyn std::error::Error>;

/// A piece of work: the surface of a shape in a cube of the world, whose octree is so deep.
#[derive(Debug, Deserialize)]
struct Request {
    listing: PathBuf,
    /// Middle of the cube.
    middle: [f32; 3],
    /// Half of its side.
    half: f32,
    depth: u8,
    threads: usize,
    /// Where to write the mesh.
    out: PathBuf,
}

/// What came of it.
#[derive(Debug, Default, Serialize)]
struct Answer {
    /// Wall time.
    seconds: f64,
    /// Why there is no result.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

fn main() -> Result<(), Failure> {
    for line in stdin().lock().lines() {
        let request: Request = serde_json::from_str(&line?)?;
        let failed = |why: Failure| Answer { error: Some(why.to_string()), ..Answer::default() };
        let answer = answer(&request).unwrap_or_else(failed);
        let mut out = stdout().lock();
        serde_json::to_writer(&mut out, &answer)?;
        out.write_all(b"\n")?;
        out.flush()?;
    }
    Ok(())
}

fn answer(request: &Request) -> Result<Answer, Failure> {
    let (mut context, inside_positive) = Context::from_text(File::open(&request.listing)?)?;
    let root = context.neg(inside_positive)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(request.threads).build()?;
    let pool = ThreadPool::Custom(pool);
    let middle = Vector3::from(request.middle);
    let settings = Settings {
        depth: request.depth,
        world_to_model: Matrix4::new_translation(&middle) * Matrix4::new_scaling(request.half),
        threads: (request.threads > 1).then_some(&pool),
        cancel: CancelToken::new(),
    };
    let start = Instant::now();
    let shape = JitShape::new(&context, root)?;
    let shape = shape.try_into().map_err(|_| "a shape of x, y and z only")?;
    let octree = Octree::build(&shape, &settings).ok_or("cancelled")?;
    let mesh = octree.walk_dual();
    let seconds = start.elapsed().as_secs_f64();
    write(&mesh, &request.out)?;
    Ok(Answer { seconds, error: None })
}

/// As PLY.
fn write(mesh: &Mesh, path: &Path) -> Result<(), Failure> {
    let mut out = BufWriter::new(File::create(path)?);
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len(),
    )?;
    for vertex in &mesh.vertices {
        vertex.iter().try_for_each(|c| out.write_all(&c.to_le_bytes()))?;
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        for &vertex in triangle {
            out.write_all(&i32::try_from(vertex)?.to_le_bytes())?;
        }
    }
    Ok(out.flush()?)
}
