//! The loops that know the type of samples, compiled here and nowhere else.
//!
//! What is generic is compiled anew by each crate that uses it. These loops are long, and there are three of each, one for
//! every level. So they are reached through a trait whose functions are not generic.

use crate::{
    Level,
    between::{CubicLook, Look},
    vertices::{Loading, Normals, Straight},
    wide::run_at,
};

macro_rules! loops {
    ($tasks:tt of $($t:ty),*) => {
        loops!(@trait $tasks);
        $(loops!(@of $t: $tasks);)*
    };
    (@trait { $($name:ident($task:ty);)* }) => {
        /// Each does a task with the instructions of a level.
        ///
        /// # Panics
        ///
        /// If the machine has not the level.
        pub trait Loops: Sized {
            $(fn $name(level: Level, task: $task);)*
        }
    };
    (@of $t:ty: { $($name:ident($task:ty);)* }) => {
        impl Loops for $t {
            $(fn $name(level: Level, task: $task) {
                run_at(level, task);
            })*
        }
    };
}

loops!({
    place_straight(Straight<'_, '_, '_, Self>);
    load(Loading<'_, '_, '_, Self, f64>);
    load_rounded(Loading<'_, '_, '_, Self, f32>);
    turn(Normals<'_, '_, '_, Self>);
    look(Look<'_, '_, Self>);
    look_cubic(CubicLook<'_, '_, Self, false>);
    look_cubic_facing(CubicLook<'_, '_, Self, true>);
} of u8, i8, u16, i16, u32, i32, f32, f64);
