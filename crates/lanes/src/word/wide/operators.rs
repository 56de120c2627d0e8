//! The operators of all packs.

/// What can be done with two registers, and with all bits of one.
macro_rules! operators {
    ($pack:ident $ones:expr, $($trait:ident $name:ident $of_two:ident),*) => {
        impl Bits for $pack {}

        impl Not for $pack {
            type Output = Self;

            #[inline(always)]
            fn not(self) -> Self {
                // SAFETY: there is a register.
                self ^ Self(unsafe { $ones })
            }
        }

        $(impl $trait for $pack {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: there is a register.
                Self(unsafe { $of_two(self.0, other.0) })
            }
        })*
    };
}
