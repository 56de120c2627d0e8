//! Solids as fields: shapes that are put together from others, and meshes.
