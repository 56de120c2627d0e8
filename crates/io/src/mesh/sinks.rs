//! A spool as the receiver of several surfaces.

use super::{MeshSpool, SpoolSink};
use crate::WriteError;
use isokit_mesh::MeshSinks;

impl MeshSinks for MeshSpool {
    type Error = WriteError;
    type Sink<'a> = SpoolSink<'a>;

    fn sink(&mut self, surface: usize) -> SpoolSink<'_> {
        self.sink(surface)
    }
}
