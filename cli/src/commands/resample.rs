//! `resample`: the same volume at other samples.

use crate::{Exit, Session, plan::ResamplePlan};
use anyhow::Result;
use isokit::{
    io::write_volume,
    pipeline::{Region, Scan, TargetSpace},
};

pub(crate) fn run(plan: &ResamplePlan, session: &mut Session<'_, '_>) -> Result<Exit> {
    session.watching(|session| -> Result<()> {
        let (space, whole, job) = (TargetSpace::Source, Region::Whole, &session.job);
        let scan = Scan::open(&plan.input, &plan.options, space, &whole, job)?;
        scan.notes().iter().for_each(|note| session.console.note(note));
        let resampled = scan.resampled(plan.filter, plan.spacing, job)?;
        drop(scan);
        write_volume(&plan.output, resampled.volume(), job)?;
        let ([nx, ny, nz], dtype) = (resampled.volume().grid().dims(), resampled.volume().dtype());
        let output = plan.output.display();
        session.console.info(&format!("wrote {output}: {nx} x {ny} x {nz} of {dtype}"));
        Ok(())
    })?;
    Ok(Exit::Done)
}
