//! Pictures that are drawn: what values look like, and what surface there is at each, over how often they occur; and
//! words on pictures.

use anyhow::Result;
use embedded_graphics::{
    mono_font::{MonoTextStyle, ascii::FONT_6X13},
    pixelcolor::Rgb888,
    prelude::*,
    primitives::{Line, PrimitiveStyle, Rectangle},
    text::{Alignment, Text, TextStyleBuilder},
};
use isokit::{
    job::Job,
    mesh::{Rgba, srgb_of_linear},
    render::{Gathered, Image, OpticalModel, Size, TransferFunction},
    spectrum::{Contour, ContourSpectrum},
    volume::Histogram,
};
use std::{convert::Infallible, num::NonZeroU32};

/// A picture to draw on.
pub(crate) struct Canvas<'a>(pub(crate) &'a mut Image);

impl OriginDimensions for Canvas<'_> {
    fn size(&self) -> embedded_graphics::geometry::Size {
        let size = self.0.size();
        embedded_graphics::geometry::Size::new(size.width.get(), size.height.get())
    }
}

impl DrawTarget for Canvas<'_> {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Infallible> {
        let size = self.0.size();
        let [width, height] = [size.width, size.height].map(|n| n.get() as usize);
        for Pixel(Point { x, y }, color) in pixels {
            let Some((x, y)) = usize::try_from(x).ok().zip(usize::try_from(y).ok()) else {
                continue;
            };
            if x < width && y < height {
                let [r, g, b, _] = Rgba([color.r(), color.g(), color.b(), u8::MAX]).to_linear();
                self.0.pixels_mut()[y * width + x] = Gathered::new([r, g, b], 1.0);
            }
        }
        Ok(())
    }
}

impl Canvas<'_> {
    /// Words whose first or last letter, or middle, is at a place, on its line.
    pub(crate) fn words(&mut self, text: &str, [x, y]: [i32; 2], color: Rgb888, side: Alignment) {
        let font = MonoTextStyle::new(&FONT_6X13, color);
        let style = TextStyleBuilder::new().alignment(side).build();
        let Ok(_) = Text::with_text_style(text, Point::new(x, y), font, style).draw(self);
    }

    fn fill(&mut self, [x, y]: [i32; 2], [width, height]: [u32; 2], color: Rgb888) {
        let size = embedded_graphics::geometry::Size::new(width, height);
        let area = Rectangle::new(Point::new(x, y), size);
        let Ok(()) = area.into_styled(PrimitiveStyle::with_fill(color)).draw(self);
    }

    fn line(&mut self, [a, b]: [[i32; 2]; 2], color: Rgb888, wide: u32) {
        let line = Line::new(Point::new(a[0], a[1]), Point::new(b[0], b[1]));
        let Ok(()) = line.into_styled(PrimitiveStyle::with_stroke(color, wide)).draw(self);
    }
}

const WIDTH: i32 = 960;
const HEIGHT: i32 = 480;
/// What is left free around the chart: left, right, top, bottom.
const FREE: [i32; 4] = [56, 24, 34, 62];
const INK: Rgb888 = Rgb888::new(0x30, 0x30, 0x30);
const GREY: Rgb888 = Rgb888::new(0xc4, 0xc8, 0xcc);
const PAPER: Rgb888 = Rgb888::new(0xff, 0xff, 0xff);
const MARK: Rgb888 = Rgb888::new(0x90, 0x90, 0x90);
/// Told apart by all eyes (Okabe & Ito 2008).
const AREA: Rgb888 = Rgb888::new(0x00, 0x9e, 0x73);
const TOTAL: Rgb888 = Rgb888::new(0x00, 0x72, 0xb2);
const MEAN: Rgb888 = Rgb888::new(0xd5, 0x5e, 0x00);

/// Where values and shares are in a chart.
#[derive(Clone, Copy)]
struct Axes {
    range: [f64; 2],
    wide: i32,
    tall: i32,
}

impl Axes {
    fn of(range: [f64; 2]) -> Self {
        let [left, right, top, bottom] = FREE;
        Self { range, wide: WIDTH - left - right, tall: HEIGHT - top - bottom }
    }

    fn span(&self) -> f64 {
        let [least, greatest] = self.range;
        if greatest > least { greatest - least } else { 1.0 }
    }

    /// The value at a column, from the first of the chart on.
    fn value(&self, column: f64) -> f64 {
        self.range[0] + self.span() * column / f64::from(self.wide - 1)
    }

    /// The column of a value.
    fn column(&self, value: f64) -> i32 {
        let share = (value - self.range[0]) / self.span();
        FREE[0] + (share * f64::from(self.wide - 1)).round() as i32
    }

    /// The row of a share of the chart's height.
    fn level(&self, share: f64) -> i32 {
        FREE[2] + self.tall - (share * f64::from(self.tall)).round() as i32
    }
}

/// A chart of how often values in a range occur, with a title, on which other things can be drawn.
fn begin(
    histogram: &Histogram,
    axes: Axes,
    (title, below): (&str, i32),
    job: &Job,
) -> Result<Image> {
    let side = |n: i32| NonZeroU32::MIN.saturating_add(n as u32 - 1);
    let size = Size { width: side(WIDTH), height: side(HEIGHT) };
    let mut image = Image::new(size, &job.limits)?;
    let mut canvas = Canvas(&mut image);
    canvas.fill([0, 0], [WIDTH as u32, HEIGHT as u32], PAPER);
    let ([left, _, top, _], Axes { wide, tall, .. }) = (FREE, axes);
    // How often values occur, by columns; logarithms let one see the few beside the many.
    let mut counts = vec![0_u64; wide as usize];
    let is_wide = axes.span() / histogram.width < f64::from(wide);
    if is_wide {
        // Bins are wider than columns: each has what its bin has.
        for (n, count) in (0..wide).zip(&mut counts) {
            let bin = (axes.value(f64::from(n)) - histogram.first) / histogram.width;
            *count = histogram.counts.get(bin.round().max(0.0) as usize).copied().unwrap_or(0);
        }
    }
    let bins = histogram.counts.iter().enumerate().filter(|_| !is_wide);
    for (bin, &count) in bins {
        let place = axes.column(histogram.middle(bin)) - left;
        if (0..wide).contains(&place) {
            counts[place as usize] += count;
        }
    }
    let most = counts.iter().copied().max().unwrap_or(0).max(1);
    for (n, &count) in (0..wide).zip(&counts) {
        let y = axes.level((count as f64).ln_1p() / (most as f64).ln_1p());
        canvas.fill([left + n, y], [1, (top + tall - y) as u32], GREY);
    }
    for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let y = axes.level(share);
        canvas.line([[left - 4, y], [left, y]], INK, 1);
        canvas.words(&format!("{share}"), [left - 8, y + 4], INK, Alignment::Right);
    }
    canvas.words(title, [left, top - 14], INK, Alignment::Left);
    canvas.line([[left, top + tall], [left + wide, top + tall]], INK, 1);
    canvas.line([[left, top], [left, top + tall]], INK, 1);
    for tick in ticks(axes.range) {
        let x = axes.column(tick);
        canvas.line([[x, top + tall], [x, top + tall + 4]], INK, 1);
        canvas.words(&format!("{tick}"), [x, top + tall + below], INK, Alignment::Center);
    }
    Ok(image)
}

impl Canvas<'_> {
    /// An isovalue, if it is in the chart, and its name.
    fn mark(&mut self, axes: Axes, (name, iso): (&str, f64), row: i32, color: Rgb888) {
        if (axes.range[0]..=axes.range[1]).contains(&iso) {
            let (x, top) = (axes.column(iso), FREE[2]);
            self.line([[x, top], [x, top + axes.tall]], color, 2);
            self.words(name, [x + 4, top + 10 + 14 * row], INK, Alignment::Left);
        }
    }

    /// A line through shares of the height at values.
    fn curve(&mut self, axes: Axes, points: impl Iterator<Item = (f64, f64)>, color: Rgb888) {
        let mut before: Option<[i32; 2]> = None;
        for (value, share) in points {
            let here = [axes.column(value), axes.level(share)];
            self.line([before.unwrap_or(here), here], color, 2);
            before = Some(here);
        }
    }
}

/// What values look like, over a histogram of them: opacities as lines, colours as a band below, and isovalues.
pub(crate) fn plot(
    histogram: &Histogram,
    model: &OpticalModel,
    isos: &[(String, f64, [f32; 3])],
    job: &Job,
) -> Result<Image> {
    let axes = Axes::of(histogram.range);
    let title = "opacity, over how often values occur (logarithm)";
    let mut image = begin(histogram, axes, (title, 40), job)?;
    let mut canvas = Canvas(&mut image);
    for (name, iso, color) in isos {
        canvas.mark(axes, (name, *iso), 0, code(*color));
    }
    // What is looked up, and the steps of functions as they are.
    let functions: Vec<&TransferFunction> = match model {
        OpticalModel::Values(function) => vec![function],
        OpticalModel::Slopes(slopes) => slopes.rows().map(|(_, function)| function).collect(),
        OpticalModel::Mixture(mixture) => vec![mixture.substance()],
    };
    for function in functions {
        let values = (0..4 * axes.wide).map(|n| axes.value(f64::from(n) / 4.0));
        let points = values.map(|value| (value, function.at(value).opacity.into()));
        canvas.curve(axes, points, INK);
    }
    for n in 0..axes.wide {
        let color = code(model.at(axes.value(f64::from(n))).color);
        canvas.fill([FREE[0] + n, FREE[2] + axes.tall + 10], [1, 14], color);
    }
    Ok(image)
}

/// What surface there is at each value, over a histogram: total gradient, mean gradient and area, each as a share of its
/// greatest; and isovalues with a number each.
pub(crate) fn spectrum_plot(
    histogram: &Histogram,
    spectrum: &ContourSpectrum,
    isos: &[f64],
    job: &Job,
) -> Result<Image> {
    let (contours, half) = (spectrum.contours(), 0.5 * spectrum.levels().width());
    let [first, last] = [contours[0].iso - half, contours[contours.len() - 1].iso + half];
    let axes = Axes::of([first, last]);
    let mut image = begin(histogram, axes, ("", 18), job)?;
    let mut canvas = Canvas(&mut image);
    for (n, iso) in isos.iter().enumerate() {
        canvas.mark(axes, (&(n + 1).to_string(), *iso), 0, MARK);
    }
    let mut x = FREE[0];
    let mut curve = |name: &str, color, of: &dyn Fn(&Contour) -> f64| {
        let most = contours.iter().map(of).fold(f64::MIN_POSITIVE, f64::max);
        canvas.curve(axes, contours.iter().map(|contour| (contour.iso, of(contour) / most)), color);
        canvas.fill([x, FREE[2] - 20], [18, 4], color);
        canvas.words(name, [x + 24, FREE[2] - 14], INK, Alignment::Left);
        x += 24 + 6 * name.len() as i32 + 20;
    };
    curve("area", AREA, &|contour| contour.area);
    curve("total gradient", TOTAL, &|contour| contour.total_gradient);
    curve("mean gradient", MEAN, &|contour| contour.mean_gradient().unwrap_or(0.0));
    let says = "as shares of the greatest, over how often values occur (logarithm)";
    canvas.words(says, [x, FREE[2] - 14], INK, Alignment::Left);
    Ok(image)
}

/// A colour in linear light as files write it.
fn code(color: [f32; 3]) -> Rgb888 {
    let [r, g, b] = color.map(|part| (srgb_of_linear(part.into()) * 255.0).round() as u8);
    Rgb888::new(r, g, b)
}

/// From five to ten round numbers in a range.
fn ticks([least, greatest]: [f64; 2]) -> Vec<f64> {
    let span = greatest - least;
    if !(span > 0.0 && span.is_finite()) {
        return vec![least];
    }
    let ten = 10.0_f64.powf(span.log10().floor() - 1.0);
    let fits = |step: &f64| span / step <= 10.0;
    let step = [1.0, 2.0, 5.0, 10.0, 20.0].map(|n| n * ten).into_iter().find(fits).unwrap_or(span);
    let first = (least / step).ceil() as i64;
    let last = (greatest / step).floor() as i64;
    // Divided, where that is a whole number, so that 0.3 is 0.3.
    let round = |n: i64| if step < 1.0 { n as f64 / step.recip().round() } else { n as f64 * step };
    (first..=last).take(12).map(round).collect()
}

#[cfg(test)]
mod tests {
    use super::ticks;

    #[test]
    fn ticks_are_five_to_ten_round_numbers() {
        assert_eq!(ticks([0.0, 100.0]), (0..=10).map(|n| 10.0 * f64::from(n)).collect::<Vec<_>>());
        assert_eq!(ticks([-1024.0, 3071.0])[..3], [-1000.0, -500.0, 0.0]);
        assert_eq!(ticks([0.05, 0.42]), [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4]);
        assert_eq!(ticks([3.0, 3.0]), [3.0]);
        for n in 0..400 {
            let span = 1.07_f64.powi(n - 200);
            let count = ticks([0.3 * span, 1.3 * span]).len();
            assert!((4..=11).contains(&count), "{span}: {count}");
        }
    }
}
