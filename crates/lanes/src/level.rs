//! What the machine can run.

use std::{env, fmt, sync::OnceLock};

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

impl Level {
    /// The levels that this machine can run, least first.
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
    /// `ISOKIT_SIMD` names, where the machine has it.
    pub fn current() -> Self {
        static CURRENT: OnceLock<Level> = OnceLock::new();
        *CURRENT.get_or_init(|| {
            let available = Self::available();
            let wanted = env::var("ISOKIT_SIMD").ok();
            let named = available.iter().find(|level| Some(level.name()) == wanted.as_deref());
            named.copied().unwrap_or_else(Self::greatest)
        })
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

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
