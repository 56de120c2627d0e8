//! One part of the picture, sheet by sheet.

use super::{
    Splatted,
    footprint::Footprint,
    sheet::{APRON, Block, Sheet, Sheets},
};
use crate::{
    Camera, Gathered, Medium, RaycastOptions, Size, Trilinear,
    raycast::Cloud,
    transfer::{Lookup, Scale},
};
use isokit_geom::vector::{Vector, dot, length};
use isokit_job::{Job, Stopped};
use isokit_volume::Sample;
use std::ops::Range;

/// Pixels of a tile along each side.
pub(super) const TILE: usize = 64;

/// The same with those around that count for gradients.
const WIDE: usize = TILE + 2 * APRON;

/// All that tiles have in common.
pub(super) struct Tiles<'a, T> {
    pub(super) medium: &'a Medium<'a, T>,
    pub(super) field: Trilinear<'a, T>,
    pub(super) camera: &'a Camera,
    pub(super) size: Size,
    pub(super) sheets: &'a Sheets,
    pub(super) footprint: &'a Footprint,
    pub(super) lookup: &'a Lookup<'a>,
    pub(super) cloud: Option<&'a Cloud>,
    pub(super) options: &'a RaycastOptions,
}

/// What was laid on a sheet: by pixels the sum of values, each times its weight, and that of weights. In f64, so that a mean
/// of values that are all the same f32 is that value: what is even has no gradient, and a step of a function no speckles.
struct Layer {
    sums: Box<[[f64; 2]; WIDE * WIDE]>,
    is_empty: bool,
}

/// What is known of a pixel.
#[derive(Clone, Copy)]
struct Pixel {
    gathered: Gathered,
    /// From where to where ahead of the camera its ray is in what is kept of the volume.
    way: [f64; 2],
    /// How its ray leads to the right and up, for each length ahead.
    slopes: [f64; 2],
    /// How long it is for each length ahead.
    stretch: f64,
    /// In index space: where its ray begins, and how far it leads for each length ahead.
    begin: Vector,
    towards: Vector,
}

impl Layer {
    fn new() -> Self {
        Self { sums: Box::new([[0.0; 2]; WIDE * WIDE]), is_empty: true }
    }

    fn clear(&mut self) {
        if !self.is_empty {
            self.sums.fill([0.0; 2]);
            self.is_empty = true;
        }
    }

    /// The value at a pixel, if there is enough of it.
    #[inline(always)]
    fn value(&self, n: usize, least: f64) -> Option<f32> {
        let [sum, weight] = self.sums[n];
        (weight > least).then(|| (sum / weight) as f32)
    }
}

impl<T: Sample> Tiles<'_, T> {
    /// The column and row of a tile's first pixel.
    pub(super) fn corner(&self, tile: usize) -> [usize; 2] {
        let columns = (self.size.width.get() as usize).div_ceil(TILE);
        [tile % columns * TILE, tile / columns * TILE]
    }

    /// Its pixels to the right and down.
    pub(super) fn extent(&self, tile: usize) -> [usize; 2] {
        let [left, top] = self.corner(tile);
        let [width, height] = [self.size.width, self.size.height].map(|n| n.get() as usize);
        [TILE.min(width - left), TILE.min(height - top)]
    }

    /// What its pixels gather, row by row, of some of all blocks: those of the first sheets first.
    pub(super) fn draw(
        &self,
        tile: usize,
        blocks: &[Block],
        bin: &[u32],
        job: &Job,
    ) -> Result<(Vec<Gathered>, Splatted), Stopped> {
        let (corner, [width, height]) = (self.corner(tile), self.extent(tile));
        let mut pixels: Vec<Pixel> = (0..width * height)
            .map(|n| self.pixel([corner[0] + n % width, corner[1] + n / width]))
            .collect();
        let deepest = pixels.iter().map(|pixel| pixel.way[1]).fold(0.0, f64::max);
        let mut done = Splatted::default();
        let mut layers = [Layer::new(), Layer::new(), Layer::new()];
        let (mut active, mut coming) = (Vec::<u32>::new(), bin.iter().copied().peekable());
        let last = bin.iter().map(|&n| blocks[n as usize].sheets[1]).max();
        let first = coming.peek().map(|&n| blocks[n as usize].sheets[0]);
        // One more, so that the last is between two.
        let last = last.unwrap_or(0);
        for number in first.into_iter().flat_map(|first| first..=last + 1) {
            job.check()?;
            let is_due = |n: &u32| blocks[*n as usize].sheets[0] <= number;
            while let Some(n) = coming.next_if(is_due) {
                active.push(n);
            }
            active.retain(|&n| blocks[n as usize].sheets[1] >= number);
            layers[number % 3].clear();
            let sheet = self.sheets.sheet(number);
            for &n in &active {
                layers[number % 3].is_empty = false;
                self.lay(&blocks[n as usize], &sheet, corner, &mut layers[number % 3], &mut done);
            }
            let Some(complete) = number.checked_sub(1).filter(|&n| !layers[n % 3].is_empty) else {
                continue;
            };
            let around = [(number + 1) % 3, complete % 3, number % 3].map(|n| &layers[n]);
            let is_open = self.gather(complete, around, width, &mut pixels);
            if !is_open {
                let left = (number..=last).map(|n| self.sheets.sheet(n).front);
                done.sheets_hidden += left.filter(|front| *front < deepest).count() as u64;
                break;
            }
        }
        Ok((pixels.into_iter().map(|pixel| pixel.gathered).collect(), done))
    }

    fn pixel(&self, place: [usize; 2]) -> Pixel {
        let ray = self.camera.pixel_ray(self.size, place.map(|c| c as f64 + 0.5));
        let along = dot(ray.direction, self.camera.forward());
        let way = self.field.interval_within(&ray, self.medium.clips).unwrap_or_default();
        Pixel {
            gathered: Gathered::NOTHING,
            way: way.map(|far| far * along),
            slopes: self.sheets.slopes(place),
            stretch: along.recip(),
            begin: self.field.affine().inverse_point(ray.origin),
            towards: self.field.affine().inverse_vector(ray.direction).map(|c| c / along),
        }
    }

    /// Lays samples on a sheet.
    fn lay(
        &self,
        block: &Block,
        sheet: &Sheet,
        corner: [usize; 2],
        layer: &mut Layer,
        done: &mut Splatted,
    ) {
        let view = self.medium.view;
        let scale = Scale::of(view.scaling());
        let [x, y, z] = block.samples.map(|[first, end]| first..end);
        // Places on the tile and around it.
        let [left, top] = corner.map(|c| c as f64 - APRON as f64);
        let per = self.footprint.squares_per();
        let [along, across] = sheet.squares().map(|square| (square * per) as f32);
        let shear = sheet.shear() as f32;
        for (k, j) in z.flat_map(|k| y.clone().map(move |j| (k, j))) {
            for i in x.clone() {
                let spot = sheet.spot([i, j, k].map(|n| n as f64));
                let Some(section) = self.footprint.section(spot.away) else { continue };
                let (column, row) = (spot.column - left, spot.row - top);
                let [wide, tall] = sheet.reach(section.radius);
                let (columns, rows) = (within(column, wide), within(row, tall));
                if columns.is_empty() || rows.is_empty() {
                    continue;
                }
                done.splats += 1;
                let value = f64::from(scale.value(view.stored([i, j, k]).to_f64() as f32));
                // One that is infinite is no number, as to rays.
                let value = if value.is_finite() { value } else { f64::NAN };
                let first = (columns.start as f64 - column) as f32;
                let top = (rows.start as f64 - row) as f32;
                for (n, row) in layer.sums[rows.start * WIDE..rows.end * WIDE]
                    .chunks_exact_mut(WIDE)
                    .enumerate()
                {
                    let below = top + n as f32;
                    let least = across * below * below;
                    let mut from = first + shear * below;
                    for [sum, weight] in &mut row[columns.clone()] {
                        let part = f64::from(section.weight(along * from * from + least));
                        *sum += part * value;
                        *weight += part;
                        from += 1.0;
                    }
                }
            }
        }
    }

    /// Puts a sheet, between that before and that after it, behind what pixels have gathered. Whether more can be seen.
    fn gather(
        &self,
        number: usize,
        layers: [&Layer; 3],
        width: usize,
        pixels: &mut [Pixel],
    ) -> bool {
        let sheet = self.sheets.sheet(number);
        let step = self.sheets.step();
        let widening = self.sheets.widening();
        // Where samples are missing around a place a part of them is enough.
        let least = 0.01 * self.footprint.sum() * widening.powi(3);
        let has_gradients = self.options.light.is_some() || self.lookup.has_slopes();
        let mut is_open = false;
        for (n, pixel) in pixels.iter_mut().enumerate() {
            let [near, far] = pixel.way;
            if pixel.gathered.opacity >= self.options.opaque || far <= sheet.front {
                continue;
            }
            is_open = true;
            let part = (far.min(sheet.front + step) - near.max(sheet.front)) / step;
            if part <= 0.0 {
                continue;
            }
            let at = (n / width + APRON) * WIDE + n % width + APRON;
            let Some(mut place) =
                layers[1].value(at, least).and_then(|value| self.lookup.place(value))
            else {
                continue;
            };
            let mut shade = None;
            if has_gradients {
                let rises = rises(layers, at, least, place.value);
                let ahead = sheet.front + 0.5 * step;
                let (gradient, towards) = self.turned(rises, pixel, ahead);
                place.slope = length(gradient);
                shade = self.options.light.map(|light| light.answer(gradient, towards));
            }
            let mut whole = self.lookup.gathered(place, shade);
            if let Some(cloud) = self.cloud {
                let (begin, towards) = (pixel.begin, pixel.towards);
                let ahead = sheet.front + 0.5 * step;
                whole = whole.dimmed(cloud.light([0, 1, 2].map(|k| begin[k] + ahead * towards[k])));
            }
            let next = whole.stretched(part.min(1.0) * pixel.stretch);
            pixel.gathered = pixel.gathered.over(next);
        }
        is_open
    }

    /// The gradient from rises to the next pixel to the right, the next down, and the next sheet; and where the ray leads:
    /// both to the right, up and ahead.
    fn turned(&self, rises: [f32; 3], pixel: &Pixel, ahead: f64) -> (Vector, Vector) {
        let wide = self.sheets.pixel(ahead);
        let [right, down, behind] = rises.map(f64::from);
        let [x, y] = [right / wide, -down / wide];
        let [to_x, to_y] = pixel.slopes;
        ([x, y, behind / self.sheets.step() - to_x * x - to_y * y], [to_x, to_y, 1.0])
    }
}

/// The places on a tile, and around it, no farther from one than so much.
#[inline(always)]
fn within(middle: f64, reach: f64) -> Range<usize> {
    let low = (middle - reach).max(0.0);
    let first = low as i32; // not the next after it, but that has no weight
    let end = (middle + reach + 1.0).clamp(0.0, WIDE as f64) as i32;
    first as usize..end as usize
}

/// By how much values rise from pixel to pixel to the right, down, and behind: between those on both sides, or from one
/// where the other is missing.
#[inline(always)]
fn rises(layers: [&Layer; 3], at: usize, least: f64, value: f32) -> [f32; 3] {
    let [before, own, after] = layers;
    let pairs = [
        [own.value(at - 1, least), own.value(at + 1, least)],
        [own.value(at - WIDE, least), own.value(at + WIDE, least)],
        [before.value(at, least), after.value(at, least)],
    ];
    pairs.map(|[low, high]| match [low, high].map(|value| value.filter(|value| !value.is_nan())) {
        [Some(low), Some(high)] => 0.5 * (high - low),
        [None, Some(high)] => high - value,
        [Some(low), None] => value - low,
        [None, None] => 0.0,
    })
}
