//! From a volume in a file to a picture: `cargo run --release -p isokit --example raycast -- VOLUME OUT.png
//! VALUE:#rrggbbaa…`, where each value's colour ends with its opacity over one spacing.

#![expect(clippy::print_stdout, reason = "it is a program")]

use isokit::{
    for_any,
    job::Job,
    pipeline::Scan,
    render::{
        Background, Camera, ControlPoint, Depth, Medium, RaycastOptions, Side, Size,
        TransferFunction, raycast, write_png,
    },
    volume::Bricks,
};
use std::{fs::File, io::BufWriter};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let usage = "usage: raycast VOLUME OUT.png VALUE:#rrggbbaa…";
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [volume, out, points @ ..] = &words[..] else { return Err(usage.into()) };
    let point = |word: &String| -> Result<ControlPoint, Box<dyn std::error::Error>> {
        let (value, color) = word.split_once(':').ok_or(usage)?;
        Ok(ControlPoint::new(value.parse()?, color.parse()?))
    };
    let model = TransferFunction::new(points.iter().map(point).collect::<Result<_, _>>()?)?.into();
    let job = Job::default();
    let scan = Scan::read(volume, &job)?;
    let size = Size { width: 800.try_into()?, height: 800.try_into()? };
    let frame = scan.frame();
    let directions = Side::Anterior.directions(frame.space);
    let (image, cast) = for_any!(scan.volume(), volume => {
        let bounds = volume.grid().bounds();
        let camera = Camera::framing(bounds, directions, Some(25.0), 1.0)?.orbited(30.0);
        let bricks = Bricks::of(&volume.view(), &job)?;
        let (view, bricks) = (&volume.view(), Some(&bricks));
        let medium = Medium { view, bricks, model: &model, clips: &[] };
        raycast(&medium, (&camera, size), &RaycastOptions::DEFAULT, &job)?
    });
    println!("{cast:?}");
    let file = BufWriter::new(File::create(out)?);
    write_png(&image, Background::Color([1.0; 3]), Depth::Eight, file)?;
    Ok(())
}
