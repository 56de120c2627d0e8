//! What a caller may choose.

/// Where new vertices go.
///
/// Not promised: that refined triangles do not cut through each other in noise, where the field curves within a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Subdivision {
    /// Nowhere.
    #[default]
    None,
    /// On every edge, so many times over: each triangle becomes four, and these four each, …; 1 to
    /// [`MOST`](Self::MOST).
    ///
    /// Not promised: an error. Where the field is smooth each division leaves about a quarter of it, down to the error of the
    /// cubic field; at steps and in noise it may leave all. Nor the least time to an error: of a smooth surface finer samples
    /// reach it sooner, where there are such (`scripts/bench_error`).
    Levels(u32),
    /// On edges along which the field curves, until no triangle leaves its surface by more than this, in world
    /// units; above 0.
    ///
    /// Not promised: more than that to first order, as second derivatives at corners and middles of sides tell it
    /// ([`Refined::bound`](crate::Refined::bound)); what the field does between them they do not see. Nor that it holds once
    /// triangles are balanced, or after the ten rounds that there are at most: what is left then is counted. Nor anything
    /// of what was sampled: the field is the cubic one through the samples, which is O(h⁴) from a smooth one.
    MaxError(f64),
}

impl Subdivision {
    /// More levels than this are taken for a mistake: each triangle becomes 4096.
    pub const MOST: u32 = 6;
}

/// How a surface is brought nearer to its field.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RefineOptions {
    /// Creases get vertices, before all else: where faces meet whose normals are more than so many degrees apart; above 0,
    /// below 180. Only a field with creases has them: one between samples has none. Default: nothing is done about them.
    ///
    /// Not promised: that each gets them. Where faces come too near to each other for the samples, or a thin triangle would turn
    /// over, a crease or a corner stays cut off.
    pub creases: Option<f64>,
    /// Where new vertices go. Default: [`Subdivision::None`].
    pub subdivision: Subdivision,
    /// Whether vertices, old and new, are moved along their normals in the end, so that triangles lie as much
    /// outside of the field's surface as inside. Then no vertex is on the surface itself, and one whose triangles would
    /// turn over, or that would meet another, stays where it was. Default: no.
    ///
    /// Not promised: the same gain everywhere. Where the surface curves both ways, as a saddle, chords lie on both sides of it
    /// already; along creases there is no sagitta to go by.
    pub balance: bool,
    /// What a file multiplies coordinates by before it rounds them to f32, as glTF has metres of a surface in millimetres;
    /// above 0. Then whatever is promised of places and triangles after rounding holds in that file too, if positions are
    /// f32 here: where they are f64, f32 cannot hold them anyway. What is farthest from the origin must be a normal number in
    /// the file too. Default: none, since other files have positions as they are.
    pub file_scale: Option<f64>,
}

impl RefineOptions {
    /// The defaults named above: nothing is done.
    pub const DEFAULT: Self =
        Self { creases: None, subdivision: Subdivision::None, balance: false, file_scale: None };

    /// The same options with vertices on creases sharper than so many degrees.
    pub const fn with_creases(self, degrees: f64) -> Self {
        Self { creases: Some(degrees), ..self }
    }

    /// The same options with another `subdivision`.
    pub const fn with_subdivision(self, subdivision: Subdivision) -> Self {
        Self { subdivision, ..self }
    }

    /// The same options, balanced in the end or not.
    pub const fn with_balance(self, balance: bool) -> Self {
        Self { balance, ..self }
    }

    /// The same options for a file that multiplies coordinates by `scale`, if by any, and rounds them.
    pub const fn with_file_scale(self, scale: Option<f64>) -> Self {
        Self { file_scale: scale, ..self }
    }

    /// Whether they leave every surface as it is.
    pub fn do_nothing(&self) -> bool {
        self.with_file_scale(None) == Self::DEFAULT
    }
}

impl Default for RefineOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}
