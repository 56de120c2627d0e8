//! The guide. Every program in it is a test.

/// From a scan to a mesh, with the program and with the library.
pub mod first_mesh {
    #![doc = include_str!("guide/first-mesh.md")]
}

/// What holds for every mesh, and which tests hold it to that.
pub mod guarantees {
    #![doc = include_str!("guide/guarantees.md")]
}

/// Solids that are put together from simple ones.
pub mod shapes {
    #![doc = include_str!("guide/shapes.md")]
}

/// Scenes, and what is promised of their pictures.
pub mod pictures {
    #![doc = include_str!("guide/pictures.md")]
}

/// Files, axes and units.
pub mod formats {
    #![doc = include_str!("guide/formats.md")]
}
