//! `suggest`: which isovalues of a volume are worth a look.

use super::to_file;
use crate::{
    Exit, Session, UsageError,
    args::SuggestArgs,
    chart::spectrum_plot,
    plan::SuggestPlan,
    report::{PERCENTS, SuggestReport, to_json},
    text::{chart, rounded},
};
use anyhow::Result;
use isokit::{
    pipeline::{Region, Scan, TargetSpace},
    render::{Background, Depth, write_png},
    spectrum::{Suggestion, suggest},
    volume::Histogram,
};

pub(crate) fn run(plan: &SuggestPlan, session: &mut Session<'_, '_>) -> Result<Exit> {
    let args = &plan.args;
    let text = session.watching(|session| -> Result<String> {
        let (options, job) = (args.volume.options(), &session.job);
        let scan = Scan::open(&args.file, &options, TargetSpace::Source, &Region::Whole, job)?;
        let spectrum = scan.spectrum(Scan::LEVELS, job)?;
        let histogram = scan.histogram(job)?;
        let both = histogram.zip(spectrum.as_ref());
        let found = both.map_or(vec![], |(histogram, spectrum)| suggest(histogram, spectrum));
        if let Some(path) = &plan.plot {
            let Some((histogram, spectrum)) = both else {
                let says = "all samples have one value, or none: there is nothing to plot";
                return Err(UsageError(says.into()).into());
            };
            let isos: Vec<f64> = found.iter().map(|one| one.iso).collect();
            let image = spectrum_plot(histogram, spectrum, &isos, job)?;
            let ground = Background::Color([1.0; 3]);
            to_file(path, session, |out| Ok(write_png(&image, ground, Depth::Eight, out)?))?;
        }
        match args.json {
            true => {
                let path = args.file.display().to_string();
                Ok(to_json(&SuggestReport::of(path, histogram, &found))?)
            }
            false => Ok(lines(args, histogram, &found)),
        }
    })?;
    session.out.write_all(text.as_bytes())?;
    Ok(Exit::Done)
}

/// What values are levels by custom: of density maps so many deviations above the mean, of others a share of the samples.
fn spread(histogram: &Histogram) -> [String; 3] {
    let [mean, deviation] = histogram.mean_and_deviation();
    let list = |all: &[String]| all.join(", ");
    let above = DEVIATIONS.map(|times| rounded(mean + times * deviation));
    let shares = PERCENTS.map(|percent| histogram.quantile(f64::from(percent) / 100.0));
    let [mean, deviation] = [mean, deviation].map(rounded);
    [
        format!("  mean {mean}, standard deviation {deviation}"),
        format!(
            "  {} deviations above the mean: {}",
            list(&DEVIATIONS.map(|n| n.to_string())),
            list(&above)
        ),
        format!(
            "  {} % of the samples up to: {}",
            list(&PERCENTS.map(|n| n.to_string())),
            list(&shares.map(rounded))
        ),
    ]
}

/// Standard deviations above the mean.
const DEVIATIONS: [f64; 4] = [1.0, 2.0, 3.0, 5.0];

fn lines(args: &SuggestArgs, histogram: Option<&Histogram>, found: &[Suggestion]) -> String {
    let mut lines = vec![];
    let Some(histogram) = histogram else {
        return format!("{}: no value is finite\n", args.file.display());
    };
    lines.push(format!("{}: samples from each value on (logarithm)", args.file.display()));
    lines.extend(chart(histogram).iter().map(|line| format!("  {line}")));
    lines.extend(spread(histogram));
    let Some(best) = found.first() else {
        lines.push("\n  no isovalue separates the samples".to_owned());
        return lines.join("\n") + "\n";
    };
    lines.push("\n     isovalue  score  why it stands out".to_owned());
    for (n, Suggestion { iso, score, reasons }) in found.iter().enumerate() {
        let number = n + 1;
        for (m, reason) in reasons.iter().enumerate() {
            lines.push(match m {
                0 => format!("{number:>3} {iso:>9}   {score:.2}  {reason}"),
                _ => format!("{:>21}{reason}", ""),
            });
        }
    }
    let file = args.file.file_name().unwrap_or_default().display();
    lines.push(format!("\n  isokit extract {file} --iso {} -o mesh.glb", best.iso));
    lines.join("\n") + "\n"
}
