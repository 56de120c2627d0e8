//! Where a node puts its mesh: affine maps in f64, singular ones too, for a node may hide by scale 0.

use gltf_json::Node;
use std::array;

/// Three columns and an origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transform {
    columns: [[f64; 3]; 3],
    origin: [f64; 3],
}

impl Transform {
    pub(super) const IDENTITY: Self =
        Self { columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], origin: [0.0; 3] };

    /// The map of a node: its matrix, or its scale, then rotation, then translation.
    pub(super) fn of(node: &Node) -> Self {
        if let Some(m) = &node.matrix {
            let column = |c: usize| array::from_fn(|row| f64::from(m[4 * c + row]));
            return Self { columns: array::from_fn(column), origin: column(3) };
        }
        let scale = node.scale.unwrap_or([1.0; 3]).map(f64::from);
        let rotation = node.rotation.map_or(Self::IDENTITY.columns, |q| rotation(q.0));
        Self {
            columns: array::from_fn(|c| rotation[c].map(|entry| entry * scale[c])),
            origin: node.translation.unwrap_or_default().map(f64::from),
        }
    }

    /// First `inner`, then this.
    pub(super) fn after(&self, inner: &Self) -> Self {
        Self {
            columns: inner.columns.map(|column| self.vector(column)),
            origin: self.point(inner.origin),
        }
    }

    pub(super) fn point(&self, xyz: [f64; 3]) -> [f64; 3] {
        let moved = self.vector(xyz);
        array::from_fn(|row| moved[row] + self.origin[row])
    }

    fn vector(&self, xyz: [f64; 3]) -> [f64; 3] {
        array::from_fn(|row| (0..3).map(|c| self.columns[c][row] * xyz[c]).sum())
    }

    /// Whether left becomes right, so that triangles turn.
    pub(super) fn is_mirror(&self) -> bool {
        let [x, y, z] = self.columns;
        dot(cross(x, y), z) < 0.0
    }

    /// The direction of a normal afterwards: by the inverse transpose, made of cofactors, as it is then
    /// defined for singular maps too. Not finite where nothing is left of it.
    pub(super) fn normal(&self, xyz: [f64; 3]) -> [f64; 3] {
        if *self == Self::IDENTITY {
            return xyz;
        }
        let [x, y, z] = self.columns;
        let sign = if self.is_mirror() { -1.0 } else { 1.0 };
        let cofactors = Self { columns: [cross(y, z), cross(z, x), cross(x, y)], origin: [0.0; 3] };
        let moved = cofactors.vector(xyz);
        let length = dot(moved, moved).sqrt();
        moved.map(|c| sign * c / length)
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}

/// The columns of the rotation that a quaternion x, y, z, w stands for, whatever its length.
fn rotation(q: [f32; 4]) -> [[f64; 3]; 3] {
    let [x, y, z, w] = q.map(f64::from);
    let square = x * x + y * y + z * z + w * w;
    let s = if square > 0.0 { 2.0 / square } else { 0.0 };
    [
        [1.0 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)],
        [s * (x * y - z * w), 1.0 - s * (x * x + z * z), s * (y * z + x * w)],
        [s * (x * z + y * w), s * (y * z - x * w), 1.0 - s * (x * x + y * y)],
    ]
}

#[cfg(test)]
mod tests {
    use super::Transform;
    use gltf_json::{Node, scene::UnitQuaternion};

    fn near(a: [f64; 3], b: [f64; 3]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
    }

    #[test]
    fn scale_comes_first_then_rotation_then_translation() {
        let half = 0.5_f32.sqrt();
        let node = Node {
            scale: Some([2.0, 1.0, 1.0]),
            rotation: Some(UnitQuaternion([0.0, 0.0, half, half])),
            translation: Some([10.0, 0.0, 0.0]),
            ..Node::default()
        };
        near(Transform::of(&node).point([1.0, 0.0, 0.0]), [10.0, 2.0, 0.0]);
        let twice = Transform::of(&node).after(&Transform::of(&node));
        near(twice.point([1.0, 0.0, 0.0]), [8.0, 20.0, 0.0]);
    }

    #[test]
    fn normals_stay_at_right_angles_and_outside() {
        let node = Node { scale: Some([1.0, 2.0, -1.0]), ..Node::default() };
        let transform = Transform::of(&node);
        assert!(transform.is_mirror());
        let half = 0.5_f64.sqrt();
        near(transform.normal([half, half, 0.0]), [2.0 / 5_f64.sqrt(), 1.0 / 5_f64.sqrt(), 0.0]);
        near(transform.normal([0.0, 0.0, 1.0]), [0.0, 0.0, -1.0]);
    }
}
