//! What the machine can run.

use std::{env, fmt, str::FromStr, sync::OnceLock};

/// A set of instructions, from the one that every machine has upwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Level {
    /// Plain Rust.
    Portable,
    /// x86-64 with AVX2, BMI1, BMI2, LZCNT and POPCNT (2013).
    Avx2,
    /// x86-64 with AVX-512 F, BW, VL, DQ, VBMI2 and VPOPCNTDQ (2019), and all of `Avx2`.
    Avx512,
}

/// The name of a level that there is not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownLevel(String);

impl Level {
    /// Every level, least first.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// The levels that this machine can run, least first.
    #[inline]
    pub fn available() -> &'static [Self] {
        static AVAILABLE: OnceLock<Vec<Level>> = OnceLock::new();
        AVAILABLE.get_or_init(|| {
            let mut levels = vec![Self::Portable];
            #[cfg(target_arch = "x86_64")]
            {
                use std::arch::is_x86_feature_detected as has;
                let avx2 = has!("avx2") && has!("bmi1") && has!("bmi2");
                if avx2 && has!("lzcnt") && has!("popcnt") {
                    levels.push(Self::Avx2);
                    let wide = has!("avx512f") && has!("avx512bw") && has!("avx512vl");
                    let more = has!("avx512dq") && has!("avx512vbmi2");
                    if wide && more && has!("avx512vpopcntdq") {
                        levels.push(Self::Avx512);
                    }
                }
            }
            levels
        })
    }

    /// The level that every loop of this process uses: the greatest there is, or the one that
    /// `ISOKIT_SIMD` names, where the machine has it. What else stands there is ignored;
    /// [`asked_for`](Self::asked_for) tells.
    #[inline]
    pub fn current() -> Self {
        static CURRENT: OnceLock<Level> = OnceLock::new();
        *CURRENT.get_or_init(|| {
            let available = Self::available();
            let wanted = Self::asked_for().ok().flatten();
            wanted.filter(|level| available.contains(level)).unwrap_or_else(Self::greatest)
        })
    }

    /// The level that `ISOKIT_SIMD` names, whether the machine has it or not; `None` if it is not set, or
    /// empty.
    ///
    /// # Errors
    ///
    /// If it names none.
    pub fn asked_for() -> Result<Option<Self>, UnknownLevel> {
        let name = env::var_os("ISOKIT_SIMD").filter(|name| !name.is_empty());
        name.map(|name| name.to_string_lossy().parse()).transpose()
    }

    /// Comes back only if the machine can run this level.
    #[inline(always)]
    pub(crate) fn assert_available(self) {
        assert!(self <= Self::greatest(), "this machine has no {self}");
    }

    #[inline]
    fn greatest() -> Self {
        let available = Self::available();
        available[available.len() - 1]
    }

    /// `portable`, `avx2` or `avx512`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

impl FromStr for Level {
    type Err = UnknownLevel;

    fn from_str(name: &str) -> Result<Self, UnknownLevel> {
        let level = Self::ALL.into_iter().find(|level| level.name() == name);
        level.ok_or_else(|| UnknownLevel(name.to_owned()))
    }
}

impl fmt::Display for UnknownLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = Level::ALL.map(Level::name).join(" ");
        write!(f, "expected one of {names}, found {:?}", self.0)
    }
}

impl std::error::Error for UnknownLevel {}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::Level;

    #[test]
    fn a_level_is_known_by_its_name_and_by_no_other() {
        for level in Level::ALL {
            assert_eq!(level.name().parse(), Ok(level));
        }
        for name in ["AVX2", "avx", "avx2 ", "sse2", ""] {
            let refusal = name.parse::<Level>().unwrap_err().to_string();
            assert_eq!(refusal, format!("expected one of portable avx2 avx512, found {name:?}"));
        }
    }

    #[test]
    fn what_a_machine_can_run_begins_with_all_levels_in_order() {
        assert!(Level::ALL.starts_with(Level::available()) && !Level::available().is_empty());
        assert!(Level::ALL.is_sorted());
    }
}
