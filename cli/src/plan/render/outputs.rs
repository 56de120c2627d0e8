//! Where pictures go, and what else there is.

use super::Subject;
use crate::{
    args::RenderArgs,
    fault::UsageError,
    plan::{Stream, TextTarget, is_png, places::Places, target::is_volume},
    scene_file::ModeWord,
};
use anyhow::Result;
use isokit::render::Channel;
use std::path::PathBuf;

/// What else surfaces have.
pub(super) fn channels(
    args: &RenderArgs,
    mode: ModeWord,
) -> Result<Vec<(Channel, PathBuf)>, UsageError> {
    let depth = args.depth.as_ref().map(|path| (Channel::Depth, path.clone()));
    let normals = args.normals.as_ref().map(|path| (Channel::Normal, path.clone()));
    if args.normals.as_ref().is_some_and(|path| !is_png(path)) {
        let says = "--normals: expected a name that ends in .png";
        return Err(UsageError(says.into()));
    }
    if args.depth.as_ref().is_some_and(|path| !is_png(path) && !is_volume(path)) {
        let says =
            "--depth: expected a name that ends in .png, or in that of a volume such as .npy";
        return Err(UsageError(says.into()));
    }
    let channels: Vec<_> = depth.into_iter().chain(normals).collect();
    if !channels.is_empty() && mode.shows_values() {
        let says = "--depth and --normals are of surfaces: add --iso, or leave them out";
        return Err(UsageError(says.into()));
    }
    Ok(channels)
}

pub(super) fn plot(args: &RenderArgs, subject: &Subject) -> Result<Option<PathBuf>, UsageError> {
    match (&args.plot, subject) {
        (Some(_), Subject::Mesh(..)) => {
            Err(UsageError("a mesh has no values: leave out --plot".into()))
        }
        (Some(path), _) if !is_png(path) => {
            let says = "--plot: expected a name that ends in .png";
            Err(UsageError(says.into()))
        }
        (path, _) => Ok(path.clone()),
    }
}

/// Where pictures and report go.
pub(super) fn targets(
    args: &RenderArgs,
    subject: &Subject,
) -> Result<(Vec<Stream>, Option<TextTarget>)> {
    let report = args.report.as_deref().map(Stream::named).transpose()?;
    let output = args.output.as_deref().filter(|_| !args.plan);
    if output.is_none() && !args.plan && (args.sheet || args.frames.is_some()) {
        let says = "--sheet and --frames are of the picture: name it with -o";
        return Err(UsageError(says.into()).into());
    }
    let frames = args.frames.map_or(1, usize::from);
    let targets = match output.map(Stream::named).transpose()? {
        None => vec![],
        Some(Stream::Stdout) if frames > 1 => {
            return Err(
                UsageError("several pictures do not fit into stdout: name a file".into()).into()
            );
        }
        Some(Stream::Stdout) if report == Some(Stream::Stdout) => {
            let says = "picture and report cannot both go to stdout: name a file for one of them";
            return Err(UsageError(says.into()).into());
        }
        Some(Stream::File(path)) if !is_png(&path) => {
            let says = format!("{}: expected a name that ends in .png", path.display());
            return Err(UsageError(says).into());
        }
        Some(Stream::File(path)) if frames > 1 => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let digits = frames.to_string().len().max(3);
            let frame = |n: usize| path.with_file_name(format!("{stem}_{n:0digits$}.png"));
            (1..=frames).map(|n| Stream::File(frame(n))).collect()
        }
        Some(one) => vec![one],
    };
    let (Subject::Volume(input, ..) | Subject::Mesh(input, _)) = subject;
    let mut places = Places::of_input(input);
    if *input != args.input {
        places.add("the scene", &args.input)?;
    }
    let others = [("--depth", &args.depth), ("--normals", &args.normals), ("--plot", &args.plot)];
    for (by, path) in others {
        if let Some(path) = path {
            Stream::named(path)?;
            places.add(by, path)?;
        }
    }
    let files = targets.iter().map(|target| ("--output", target));
    for (by, stream) in files.chain(report.as_ref().map(|report| ("--report", report))) {
        if let Stream::File(path) = stream {
            places.add(by, path)?;
        }
    }
    Ok((targets, report))
}
