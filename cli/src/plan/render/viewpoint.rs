//! From where a picture is taken.

use crate::{
    args::RenderArgs,
    fault::UsageError,
    scene_file::{At, CameraTable, ProjectionWord, SideWord},
};
use isokit::{
    render::{Projection, Side},
    scene::Viewpoint,
};

/// The angle of a perspective without other words.
const FOV: f64 = 30.0;

/// From where it is seen: from a place if the file has one and no side was typed, else from a side.
pub(super) fn of(args: &RenderArgs, table: &CameraTable) -> Result<Viewpoint, UsageError> {
    let refuse = |says: &str| Err(UsageError(format!("[camera]: {says}")));
    let is_parallel = match table.projection {
        _ if args.fov.is_some() => false,
        Some(projection) => args.parallel || projection == ProjectionWord::Parallel,
        None => args.parallel || table.height.is_some(),
    };
    let fov = args.fov.or(table.fov).unwrap_or(FOV);
    if table.fov.is_some() && table.height.is_some() {
        return refuse(
            "fov is for a perspective and height for a parallel projection: leave out one",
        );
    }
    match table.projection {
        Some(ProjectionWord::Perspective) if table.height.is_some() => {
            return refuse("height is for a parallel projection, not for a perspective");
        }
        Some(ProjectionWord::Parallel) if table.fov.is_some() => {
            return refuse("fov is for a perspective, not for a parallel projection");
        }
        _ => {}
    }
    if !table.orbit.is_none_or(f64::is_finite) {
        return refuse("orbit: expected degrees, a finite number");
    }
    if let (Some(from), None) = (table.from, args.view) {
        if table.view.is_some() {
            return refuse("expected either from or view, found both");
        }
        let at = match table.at {
            None | Some(At::Center(_)) => None,
            Some(At::Place(place)) => Some(place),
        };
        let projection = match (is_parallel, table.height) {
            (true, Some(height)) => Projection::Parallel { height },
            (true, None) => return refuse("a parallel projection from a place needs a height"),
            (false, _) => Projection::Perspective { fov },
        };
        let up = table.up.unwrap_or([0.0, 0.0, 1.0]);
        let orbit = args.orbit.or(table.orbit).unwrap_or(0.0);
        return Ok(Viewpoint::At { from, at, up, orbit, projection });
    }
    if table.from.is_none() && (table.at.is_some() || table.up.is_some() || table.height.is_some())
    {
        return refuse("at, up and height are for a camera at a place: add from");
    }
    let side = match args.view.or(table.view).unwrap_or_default() {
        SideWord::Anterior => Side::Anterior,
        SideWord::Posterior => Side::Posterior,
        SideWord::Left => Side::Left,
        SideWord::Right => Side::Right,
        SideWord::Superior => Side::Superior,
        SideWord::Inferior => Side::Inferior,
    };
    let orbit = args.orbit.or(table.orbit).unwrap_or(0.0);
    Ok(Viewpoint::Framed { side, orbit, fov: (!is_parallel).then_some(fov), turns: false })
}

/// The way around, in as many steps.
pub(super) fn around(viewpoint: Viewpoint, frames: usize) -> Vec<Viewpoint> {
    let at = |n: usize| {
        let further = 360.0 / frames as f64 * n as f64;
        match viewpoint {
            _ if frames == 1 => viewpoint,
            Viewpoint::Framed { side, orbit, fov, .. } => {
                Viewpoint::Framed { side, orbit: orbit + further, fov, turns: true }
            }
            Viewpoint::At { from, at, up, orbit, projection } => {
                Viewpoint::At { from, at, up, orbit: orbit + further, projection }
            }
        }
    };
    (0..frames).map(at).collect()
}
