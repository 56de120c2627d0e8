//! `sample`: a volume of a shape.

use crate::{Exit, Session, args::FloatArg, plan::SamplePlan, shape_file::read_shape};
use anyhow::{Context, Result};
use isokit::{io::write_volume, volume::AnyVolume};

pub(crate) fn run(plan: &SamplePlan, session: &mut Session<'_, '_>) -> Result<Exit> {
    session.watching(|session| -> Result<()> {
        let (solid, job) = (read_shape(&plan.input)?, &session.job);
        let grid = solid.grid(plan.spacing).with_context(|| plan.input.display().to_string())?;
        session.console.detail(&format!("a value takes {} steps", solid.steps()));
        let placed = solid.placed(&grid);
        let volume: AnyVolume = match plan.dtype {
            FloatArg::F32 => placed.volume::<f32>(job)?.into(),
            FloatArg::F64 => placed.volume::<f64>(job)?.into(),
        };
        write_volume(&plan.output, &volume, job)?;
        let ([nx, ny, nz], dtype) = (grid.dims(), volume.dtype());
        let output = plan.output.display();
        session.console.info(&format!("wrote {output}: {nx} x {ny} x {nz} of {dtype}"));
        Ok(())
    })?;
    Ok(Exit::Done)
}
