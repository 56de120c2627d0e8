//! The numbers behind an accessor: any component type, interleaved or not, sparse or not. Every range is
//! checked against the buffer before a number is read or memory is taken.

use super::buffers::missing;
use crate::{Place, ReadFault, mesh::input::MeshFile};
use gltf_json::{
    Accessor, Index, Root,
    accessor::{ComponentType, GenericComponentType, Type, sparse::Sparse},
    buffer::View,
    validation::Checked,
};
use std::{array, borrow::Cow};

/// All accessors of a document.
pub(super) struct Accessors<'a> {
    pub(super) file: MeshFile<'a>,
    pub(super) root: &'a Root,
    pub(super) buffers: &'a [Cow<'a, [u8]>],
}

/// Elements in a buffer, all inside it.
struct Run<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: ComponentType,
}

impl Run<'_> {
    fn number(&self, element: usize, k: usize) -> f64 {
        let at = element * self.stride + k * self.component.size();
        let bytes = |n: usize| &self.bytes[at..at + n];
        let two = || [bytes(2)[0], bytes(2)[1]];
        let four = || [bytes(4)[0], bytes(4)[1], bytes(4)[2], bytes(4)[3]];
        match self.component {
            ComponentType::I8 => f64::from(self.bytes[at] as i8),
            ComponentType::U8 => self.bytes[at].into(),
            ComponentType::I16 => i16::from_le_bytes(two()).into(),
            ComponentType::U16 => u16::from_le_bytes(two()).into(),
            ComponentType::U32 => u32::from_le_bytes(four()).into(),
            ComponentType::F32 => f32::from_le_bytes(four()).into(),
        }
    }

    fn element<const N: usize>(&self, element: usize) -> [f64; N] {
        array::from_fn(|k| self.number(element, k))
    }
}

impl Accessors<'_> {
    /// The vectors of an accessor.
    pub(super) fn vectors(&self, index: Index<Accessor>) -> Result<Vec<[f64; 3]>, ReadFault> {
        self.elements(index, Type::Vec3)
    }

    /// The colours of an accessor, with or without opacity, in linear light.
    pub(super) fn colors(&self, index: Index<Accessor>) -> Result<Vec<[f64; 4]>, ReadFault> {
        let shape = self.root.get(index).map(|accessor| accessor.type_);
        if shape == Some(Checked::Valid(Type::Vec3)) {
            let opaque = |[r, g, b]: [f64; 3]| [r, g, b, 1.0];
            return Ok(self.vectors(index)?.into_iter().map(opaque).collect());
        }
        self.elements(index, Type::Vec4)
    }

    /// The numbers of an accessor of somebody's own; none if it holds something else.
    pub(super) fn scalars(&self, index: Index<Accessor>) -> Option<Result<Vec<f32>, ReadFault>> {
        let shape = self.root.get(index).map(|accessor| accessor.type_);
        if shape.is_some_and(|shape| shape != Checked::Valid(Type::Scalar)) {
            return None;
        }
        let numbers = self.elements::<1>(index, Type::Scalar);
        Some(numbers.map(|all| all.into_iter().map(|[number]| number as f32).collect()))
    }

    /// The whole numbers of an accessor.
    pub(super) fn indices(&self, index: Index<Accessor>) -> Result<Vec<u32>, ReadFault> {
        let place = Place::Item("accessor", index.value() as u64);
        let accessor = self.root.get(index);
        if let Some(Checked::Valid(GenericComponentType(component))) =
            accessor.map(|a| a.component_type)
            && !matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
        {
            let found = format!("{component:?}");
            return Err(self.file.broken(place, "indices without sign", found));
        }
        let numbers = self.elements::<1>(index, Type::Scalar)?;
        Ok(numbers.into_iter().map(|[number]| number as u32).collect())
    }

    fn elements<const N: usize>(
        &self,
        index: Index<Accessor>,
        shape: Type,
    ) -> Result<Vec<[f64; N]>, ReadFault> {
        let place = Place::Item("accessor", index.value() as u64);
        let accessor = self.root.get(index);
        let accessor = accessor.ok_or_else(|| missing(self.file, place, "an accessor"))?;
        let Checked::Valid(GenericComponentType(component)) = accessor.component_type else {
            return Err(self.file.broken(place, "a component type of glTF 2.0", "another"));
        };
        if accessor.type_ != Checked::Valid(shape) {
            let found = match accessor.type_ {
                Checked::Valid(found) => format!("{found:?}"),
                Checked::Invalid => "a type that glTF 2.0 has not".to_owned(),
            };
            return Err(self.file.broken(place, format!("elements of {shape:?}"), found));
        }
        let count = accessor.count.0;
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let run =
            accessor.buffer_view.map(|view| self.run::<N>(view, offset, count, component, place));
        let run = run.transpose()?;
        // Without a view all are 0, and nothing in the file holds them.
        let held: usize = self.buffers.iter().map(|buffer| buffer.len()).sum();
        if run.is_none() && count > held as u64 {
            let found = format!("{count} and no view");
            return Err(self.file.broken(place, "no more elements than bytes", found));
        }
        let mut elements = self.file.job.limits.vec("an accessor", Some(count))?;
        for element in 0..count as usize {
            self.file.pace(element)?;
            elements.push(run.as_ref().map_or([0.0; N], |run| run.element(element)));
        }
        if let Some(sparse) = &accessor.sparse {
            self.replace(&mut elements, sparse, component, place)?;
        }
        if accessor.normalized {
            elements
                .iter_mut()
                .flatten()
                .for_each(|number| *number = normalized(*number, component));
        }
        Ok(elements)
    }

    /// Puts the values of a sparse accessor in their places.
    fn replace<const N: usize>(
        &self,
        elements: &mut [[f64; N]],
        sparse: &Sparse,
        component: ComponentType,
        place: Place,
    ) -> Result<(), ReadFault> {
        let (count, indices, values) = (sparse.count.0, &sparse.indices, &sparse.values);
        let Checked::Valid(index) = indices.component_type else {
            return Err(self.file.broken(place, "indices without sign", "others"));
        };
        let places =
            self.run::<1>(indices.buffer_view, indices.byte_offset.0, count, index.0, place)?;
        let values =
            self.run::<N>(values.buffer_view, values.byte_offset.0, count, component, place)?;
        for number in 0..count as usize {
            let [at] = places.element::<1>(number);
            let length = elements.len();
            let Some(element) = elements.get_mut(at as usize) else {
                let expected = format!("sparse indices below {length}");
                return Err(self.file.broken(place, expected, at.to_string()));
            };
            *element = values.element(number);
        }
        Ok(())
    }

    fn run<const N: usize>(
        &self,
        view: Index<View>,
        offset: u64,
        count: u64,
        component: ComponentType,
        place: Place,
    ) -> Result<Run<'_>, ReadFault> {
        let view = self.root.get(view).ok_or_else(|| missing(self.file, place, "a buffer view"))?;
        let buffer = self.buffers.get(view.buffer.value());
        let buffer = buffer.ok_or_else(|| missing(self.file, place, "a buffer"))?;
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let end = start.checked_add(view.byte_length.0);
        let held = buffer.len() as u64;
        let end = end.filter(|&end| end <= held).ok_or_else(|| {
            self.file.truncated("a buffer view", start.saturating_add(view.byte_length.0), held)
        })?;
        let size = N * component.size();
        let stride = view.byte_stride.map_or(size, |stride| stride.0);
        // From the first byte of the first element to the last of the last.
        let last = count.checked_sub(1);
        let needed = match last {
            None => Some(offset),
            Some(last) => last
                .checked_mul(stride as u64)
                .and_then(|bytes| bytes.checked_add(size as u64))
                .and_then(|bytes| bytes.checked_add(offset)),
        };
        let held = end - start;
        if needed.is_none_or(|needed| needed > held) {
            return Err(self.file.truncated("an accessor", needed.unwrap_or(u64::MAX), held));
        }
        if stride < size {
            let found = format!("{stride} bytes");
            return Err(self.file.broken(place, format!("a stride of at least {size}"), found));
        }
        // Both are within a buffer that is in memory.
        let bytes = &buffer[start as usize..end as usize][offset as usize..];
        Ok(Run { bytes, stride, component })
    }
}

/// An integer as the part of its range that it stands for.
fn normalized(number: f64, component: ComponentType) -> f64 {
    match component {
        ComponentType::I8 => (number / f64::from(i8::MAX)).max(-1.0),
        ComponentType::U8 => number / f64::from(u8::MAX),
        ComponentType::I16 => (number / f64::from(i16::MAX)).max(-1.0),
        ComponentType::U16 => number / f64::from(u16::MAX),
        ComponentType::U32 | ComponentType::F32 => number,
    }
}
