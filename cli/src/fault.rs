//! Whose fault an error is, and what can be done about it.

use anyhow::Error;
use isokit::{
    field::ResampleError,
    io::{ReadError, ReadFault, WriteError, WriteFault},
    job::{OverLimit, Stopped, ThreadsError},
    marching_cubes::ExtractError,
    pipeline::PipelineError,
    refine::RefineError,
    render::{RasterError, RaycastError},
    scene::SceneError,
    solid::ShapeError,
};
use std::{error::Error as StdError, io};

/// Words that do not fit together. Found before anything is opened.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct UsageError(pub(crate) String);

impl std::fmt::Display for UsageError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl StdError for UsageError {}

/// A request that cannot be met, and what could be asked for instead.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct CallerError {
    pub(crate) message: String,
    pub(crate) advice: &'static str,
}

impl std::fmt::Display for CallerError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl StdError for CallerError {}

/// Who can do something about an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Wrong usage.
    Usage,
    Caller(&'static str),
    File(&'static str),
    System(&'static str),
    Ours(&'static str),
    /// The user stopped it.
    Interrupted,
    /// Whoever read stdout has read enough.
    NobodyListens,
}

impl Fault {
    pub(crate) fn of(error: &Error) -> Self {
        error
            .chain()
            .find_map(known)
            .unwrap_or(Self::Ours("this should not happen; please report it"))
    }

    /// Whose it is, in words.
    pub(crate) fn whose(self) -> &'static str {
        match self {
            Self::Usage | Self::Caller(_) => "the caller's fault",
            Self::File(_) => "the file's fault",
            Self::System(_) => "the system's fault",
            Self::Ours(_) => "isokit's fault",
            Self::Interrupted | Self::NobodyListens => "nobody's fault",
        }
    }

    /// What can be done.
    pub(crate) fn advice(self) -> &'static str {
        match self {
            Self::Usage => "`isokit COMMAND --help` says what fits together, with an example",
            Self::Caller(advice) | Self::File(advice) => advice,
            Self::System(advice) | Self::Ours(advice) => advice,
            Self::Interrupted | Self::NobodyListens => "run it again",
        }
    }
}

fn known(error: &(dyn StdError + 'static)) -> Option<Fault> {
    let pipeline = error.downcast_ref().map(of_pipeline);
    let scene = || error.downcast_ref().map(of_scene);
    let usage = || error.downcast_ref::<UsageError>().map(|_| Fault::Usage);
    let caller = || error.downcast_ref().map(|error: &CallerError| Fault::Caller(error.advice));
    let shape = || error.downcast_ref().map(of_shape);
    let read = || error.downcast_ref::<ReadError>().map(|error| of_read(&error.fault));
    let write = || error.downcast_ref::<WriteError>().map(|error| of_write(&error.fault));
    let stopped = || error.downcast_ref::<Stopped>().map(of_stopped);
    let over = || error.downcast_ref::<OverLimit>().map(|over| of_stopped(&(*over).into()));
    let cancelled = || error.downcast_ref::<isokit::job::Cancelled>().map(|_| Fault::Interrupted);
    let system = || error.downcast_ref().map(of_system);
    let threads = || error.downcast_ref().map(of_threads);
    let found = pipeline
        .or_else(scene)
        .or_else(shape)
        .or_else(usage)
        .or_else(caller)
        .or_else(read)
        .or_else(write)
        .or_else(stopped);
    found.or_else(over).or_else(cancelled).or_else(threads).or_else(system)
}

fn of_threads(error: &ThreadsError) -> Fault {
    const ADVICE: &str = "use fewer --threads";
    match error {
        ThreadsError::TooMany { .. } => Fault::Caller(ADVICE),
        ThreadsError::NotStarted { .. } => Fault::System(ADVICE),
    }
}

fn of_pipeline(error: &PipelineError) -> Fault {
    match error {
        PipelineError::Read(error) => of_read(&error.fault),
        PipelineError::Write(error) => of_write(&error.fault),
        PipelineError::Stopped(stopped) => of_stopped(stopped),
        PipelineError::Extract(error) => of_extract(error),
        PipelineError::Refine(error) => of_refine(error),
        PipelineError::Space(_) => {
            Fault::Caller("leave --space out, or use --space index for sample numbers")
        }
        PipelineError::Region(_) => {
            Fault::Caller("choose a part within the volume; `isokit info` shows its size and place")
        }
        PipelineError::Resample(error) => of_resample(error),
        PipelineError::Iso { .. } => {
            Fault::File("give --iso a number; `isokit info` shows the range")
        }
        _ => Fault::Ours("this should not happen; please report it"),
    }
}

fn of_scene(error: &SceneError) -> Fault {
    match error {
        SceneError::Pipeline(error) => of_pipeline(error),
        SceneError::Camera(_) => {
            Fault::Caller("look at [camera], or leave it out to see all of it")
        }
        SceneError::Raster(RasterError::Stopped(stopped))
        | SceneError::Raycast(RaycastError::Stopped(stopped))
        | SceneError::Stopped(stopped) => of_stopped(stopped),
        SceneError::Raster(RasterError::Size(_)) => Fault::Caller("choose a smaller --size"),
        SceneError::Raster(RasterError::Triangles(_)) => {
            Fault::Ours("show fewer surfaces, or cut some away with [[clip]]")
        }
        SceneError::Raycast(RaycastError::Length { .. }) => {
            Fault::Caller("look at [sampling] step and [transfer] unit")
        }
        SceneError::UnknownSurface(_) => {
            Fault::Caller("give [[surface]] and [[clip]] the same names")
        }
        SceneError::NoTransfer => Fault::Caller("give [transfer] points or a preset"),
        SceneError::NoValues => Fault::Caller("leave out cap, or show the volume of the mesh"),
        _ => Fault::Ours("this should not happen; please report it"),
    }
}

fn of_shape(error: &ShapeError) -> Fault {
    match error.place.as_str() {
        "spacing" => Fault::Caller("choose another --spacing"),
        _ => Fault::Caller("look at that place in the shape; `isokit sample --help` shows one"),
    }
}

fn of_resample(error: &ResampleError) -> Fault {
    match error {
        ResampleError::Spacing { .. } => {
            Fault::Caller("`isokit info` shows how far the volume's samples are from each other")
        }
        ResampleError::TooMany { .. } => Fault::Ours("choose a greater --spacing"),
        ResampleError::NotFinite { .. } => Fault::File(
            "with --kernel catmull-rom, or --smoothing, it is missed near that sample only",
        ),
        ResampleError::Stopped(stopped) => of_stopped(stopped),
        _ => Fault::Ours("this should not happen; please report it"),
    }
}

fn of_extract(error: &ExtractError) -> Fault {
    match error {
        ExtractError::Nan { .. } => Fault::File(
            "go on with --nan outside, which closes the surface around them, or --nan mask, which \
             leaves it open there",
        ),
        ExtractError::TooLarge { .. } => Fault::Ours(
            "take parts of the volume with --roi, or another isovalue; --max-memory does not help",
        ),
        ExtractError::TooFar { .. } => {
            Fault::Caller("give an --origin nearer to 0, or use --space index for sample numbers")
        }
        ExtractError::TooLong { .. } => Fault::Ours("take a part with --roi"),
        ExtractError::Unfitted { .. } => Fault::Caller("leave out --diagonals fitted"),
        ExtractError::Iso(_) => {
            Fault::Caller("choose another isovalue; `isokit info` shows the range")
        }
        ExtractError::Stopped(stopped) => of_stopped(stopped),
        _ => Fault::Ours("this should not happen; please report it"),
    }
}

fn of_refine(error: &RefineError) -> Fault {
    match error {
        RefineError::Stopped(stopped) => of_stopped(stopped),
        RefineError::TooLarge { .. } => {
            Fault::Caller("divide less, with --refine or --max-error, or take a part with --roi")
        }
        _ => Fault::Ours("this should not happen; please report it"),
    }
}

fn of_read(fault: &ReadFault) -> Fault {
    match fault {
        ReadFault::Io(error) => of_system(error),
        ReadFault::Broken { format, .. } | ReadFault::Truncated { format, .. } => {
            Fault::File(match format.is_volume() {
                true => {
                    "get or make it again; sound samples are read with --dims, --dtype and --skip"
                }
                false => "get or make it again",
            })
        }
        ReadFault::Unsupported { .. } => {
            Fault::Ours("convert the file with the program that made it")
        }
        ReadFault::OverLimit(_) => Fault::System("it has not so much memory"),
        ReadFault::Caller(_) => Fault::Caller(
            "`isokit info` shows what a file is, and `isokit info --help` how to describe one",
        ),
        ReadFault::Colors(_) => Fault::Caller(
            "`isokit extract --attribute` takes it, for the colours of vertices; `isokit info` shows it",
        ),
        ReadFault::Cancelled(_) => Fault::Interrupted,
        _ => Fault::Ours("this should not happen; please report it"),
    }
}

fn of_write(fault: &WriteFault) -> Fault {
    match fault {
        WriteFault::Io(error) => of_system(error),
        // What the format is short of, and what to do about that, it says itself.
        WriteFault::TooLarge { .. } => Fault::Caller("do so, or take a part with --roi"),
        WriteFault::Caller(_) => Fault::Caller("choose another name or format for the output"),
        WriteFault::OverLimit(_) => Fault::System("it has not so much memory"),
        WriteFault::Cancelled(_) => Fault::Interrupted,
        _ => Fault::Ours("this should not happen; please report it"),
    }
}

fn of_stopped(stopped: &Stopped) -> Fault {
    match stopped {
        Stopped::Cancelled(_) => Fault::Interrupted,
        Stopped::OverLimit(_) => Fault::System(
            "it has not so much memory; take a part with --roi, or allow more if you set a limit",
        ),
    }
}

fn of_system(error: &io::Error) -> Fault {
    match error.kind() {
        io::ErrorKind::BrokenPipe => Fault::NobodyListens,
        io::ErrorKind::NotFound => Fault::Caller("look at the path: there is nothing there"),
        io::ErrorKind::InvalidInput | io::ErrorKind::IsADirectory => {
            Fault::Caller("name a file that can be read")
        }
        io::ErrorKind::PermissionDenied => Fault::System("ask for access, or choose another place"),
        io::ErrorKind::StorageFull => Fault::System("make room, or choose another place"),
        _ => Fault::System("see whether the place can be read and written otherwise"),
    }
}

#[cfg(test)]
mod tests {
    use super::{Fault, UsageError};
    use anyhow::{Context, Error};
    use isokit::{
        io::{Format, ReadFault, WriteFault},
        job::{Cancelled, OverLimit},
        marching_cubes::ExtractError,
        pipeline::PipelineError,
    };
    use std::io;

    #[test]
    fn a_fault_is_found_behind_what_others_say_of_it() {
        let read = |fault: ReadFault| Error::from(PipelineError::from(fault.at("a.nii")));
        let lost = io::Error::from(io::ErrorKind::NotFound);
        assert_eq!(Fault::of(&read(lost.into())).whose(), "the caller's fault");
        assert_eq!(Fault::of(&read(Cancelled.into())), Fault::Interrupted);
        let nan = PipelineError::from(ExtractError::Nan { count: 3, first: [0; 3] });
        let fault = Fault::of(&Error::from(nan).context("while extracting"));
        assert!(fault.advice().contains("--nan outside"));
        assert_eq!(fault.whose(), "the file's fault");
        let over = OverLimit { what: "volume", needed: 8, limit: 7 };
        assert_eq!(Fault::of(&PipelineError::from(over).into()).whose(), "the system's fault");
    }

    #[test]
    fn an_isovalue_is_blamed_for_what_another_one_mends() {
        let of = |error: ExtractError| Fault::of(&PipelineError::from(error).into());
        let long = of(ExtractError::TooLong { axis: 2, size: 1 << 31 });
        assert_eq!((long.whose(), long.advice()), ("isokit's fault", "take a part with --roi"));
        let large = of(ExtractError::TooLarge { vertices: 1 << 32, triangles: 1 << 33 });
        assert_eq!(large.whose(), "isokit's fault");
        for option in ["--roi", "another isovalue", "--max-memory does not help"] {
            assert!(large.advice().contains(option), "{}", large.advice());
        }
        let iso = of(ExtractError::Iso(f64::NAN));
        assert_eq!(iso.whose(), "the caller's fault");
        assert!(iso.advice().contains("another isovalue"));
    }

    #[test]
    fn a_format_that_is_too_small_says_itself_what_to_do() {
        let remedy = "write .ply";
        let (what, needed, limit) = ("triangles", 1 << 32, u32::MAX.into());
        let fault = WriteFault::TooLarge { format: Format::Stl, what, needed, limit, remedy };
        let error = Error::from(PipelineError::from(fault.at("a.stl")));
        assert!(error.to_string().ends_with("; write .ply"), "{error}");
        let fault = Fault::of(&error);
        assert_eq!(fault.whose(), "the caller's fault");
        assert_eq!(fault.advice(), "do so, or take a part with --roi");
    }

    #[test]
    fn memory_is_the_systems_in_reading_and_in_writing() {
        let over = OverLimit { what: "edges", needed: 8, limit: 7 };
        let read = PipelineError::from(ReadFault::from(over).at("a.nii"));
        let write = PipelineError::from(WriteFault::from(over).at("a.ply"));
        for error in [read.into(), write.into(), over.into()] {
            assert_eq!(Fault::of(&error).whose(), "the system's fault");
        }
    }

    #[test]
    fn a_reader_that_has_read_enough_is_nobodys_fault() {
        let error = Err::<(), _>(io::Error::from(io::ErrorKind::BrokenPipe)).context("stdout");
        assert_eq!(Fault::of(&error.unwrap_err()), Fault::NobodyListens);
    }

    #[test]
    fn an_unknown_error_is_ours() {
        assert_eq!(Fault::of(&Error::msg("?")).whose(), "isokit's fault");
        assert_eq!(Fault::of(&Error::from(UsageError("?".into()))), Fault::Usage);
    }
}
