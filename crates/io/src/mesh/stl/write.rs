//! Writes binary STL.

use crate::{
    Format, WriteFault,
    mesh::{
        MeshContext, Written, facts,
        outline::Outline,
        rounding::Loss,
        stream::{Stream, put_f32},
    },
};
use isokit_job::Job;
use isokit_mesh::{Precision, Surface};
use std::io::Write;

/// Writes one surface.
pub(in crate::mesh) fn write(
    out: &mut dyn Write,
    surface: &Surface,
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<(), WriteFault> {
    let (mesh, outline) = (&surface.mesh, Outline::from(surface));
    let head = head(&outline, context)?;
    // f32 is written as it is, and loses nothing.
    if outline.precision == Precision::F64 {
        Loss::of(&mesh.positions, stored, |xyz| xyz, job)?.report(&outline, Format::Stl, written);
    }
    job.progress.begin("write", outline.counts.triangles);
    let mut stream = Stream::new(out, job);
    stream.put(&head);
    put_facets(&mut stream, &mesh.triangles, |triangle| mesh.corners(triangle).map(stored))?;
    stream.finish()
}

/// All that comes before the first triangle.
pub(super) fn head(outline: &Outline, context: &MeshContext) -> Result<Vec<u8>, WriteFault> {
    let count = count(outline.counts.triangles)?;
    let text = header(&facts::in_one_line(context, &outline.head));
    Ok([&text[..], &count.to_le_bytes()].concat())
}

/// Puts triangles, given where their corners are.
pub(super) fn put_facets(
    stream: &mut Stream<'_>,
    triangles: &[[u32; 3]],
    corners: impl Fn([u32; 3]) -> [[f32; 3]; 3],
) -> Result<(), WriteFault> {
    stream.items(triangles, |bytes, &triangle| {
        let corners = corners(triangle);
        put_f32(bytes, normal(corners));
        corners.into_iter().for_each(|corner| put_f32(bytes, corner));
        bytes.extend([0; 2]);
    })
}

pub(super) fn stored(xyz: [f64; 3]) -> [f32; 3] {
    xyz.map(|c| c as f32)
}

/// Goes on if the header can count so many.
pub(in crate::mesh) fn check(triangles: u64) -> Result<(), WriteFault> {
    count(triangles).map(drop)
}

fn count(triangles: u64) -> Result<u32, WriteFault> {
    u32::try_from(triangles).map_err(|_| WriteFault::TooLarge {
        format: Format::Stl,
        what: "triangles",
        needed: triangles,
        limit: u32::MAX.into(),
        remedy: "write .ply",
    })
}

/// 80 bytes: as much of the text as fits, then zeros.
fn header(text: &str) -> [u8; 80] {
    let mut header = [0; 80];
    let most = text.len().min(header.len());
    let end = (0..=most).rev().find(|&end| text.is_char_boundary(end)).unwrap_or(0);
    header[..end].copy_from_slice(&text.as_bytes()[..end]);
    header
}

/// The unit normal of a triangle as it is written; zero if it has no direction.
fn normal(corners: [[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    let [u, v] = [b, c].map(|corner| std::array::from_fn::<_, 3, _>(|k| corner[k] - a[k]));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = cross.iter().map(|c| c * c).sum::<f64>().sqrt();
    let unit = cross.map(|c| (c / length) as f32);
    if unit.iter().all(|c| c.is_finite()) { unit } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::{count, header, normal};

    #[test]
    fn more_triangles_than_the_count_can_say_are_refused() {
        assert_eq!(count(4_294_967_295).unwrap(), u32::MAX);
        let error = count(4_294_967_296).unwrap_err().to_string();
        assert_eq!(
            error,
            "STL holds at most 4294967295 triangles, this needs 4294967296; write .ply"
        );
    }

    #[test]
    fn a_header_is_cut_between_letters() {
        let cut = header(&format!("{}é", "x".repeat(79)));
        assert_eq!((cut[78], cut[79]), (b'x', 0));
    }

    #[test]
    fn normals_have_length_one_or_none() {
        assert_eq!(normal([[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]]), [0.0, 0.0, 1.0]);
        assert_eq!(normal([[1.0; 3]; 3]), [0.0; 3]);
        assert_eq!(normal([[f32::NAN; 3]; 3]), [0.0; 3]);
        let tiny = 1e-30;
        assert_eq!(normal([[0.0; 3], [tiny, 0.0, 0.0], [0.0, tiny, 0.0]]), [0.0, 0.0, 1.0]);
    }
}
