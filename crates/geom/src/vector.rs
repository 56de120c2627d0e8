//! The few things done with three numbers at once, as plain arrays.

/// A position, a displacement or a covector.
pub type Vector = [f64; 3];

/// The displacement from `b` to `a`.
#[inline]
pub fn sub(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| a[k] - b[k])
}

/// The scalar product.
#[inline]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
#[inline]
pub fn cross(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}

/// The length.
#[inline]
pub fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The same direction, one long, however long or short it is; none of 0 and of what is not finite.
#[inline]
pub fn unit(a: Vector) -> Option<Vector> {
    let largest = a.into_iter().fold(0.0, |most: f64, c| most.max(c.abs()));
    let scaled = a.map(|c| c / largest);
    let long = length(scaled);
    (long > 0.0 && long.is_finite()).then(|| scaled.map(|c| c / long))
}

/// The normal of a triangle, counter-clockwise seen from its tip; its length is twice the area.
#[inline]
pub fn normal([a, b, c]: [Vector; 3]) -> Vector {
    cross(sub(b, a), sub(c, a))
}

#[cfg(test)]
mod tests {
    use super::unit;

    #[test]
    fn a_direction_is_one_long_whatever_its_length() {
        for factor in [1e-300, 1.0, 1e300] {
            let [x, y, z] = unit([3.0, 0.0, -4.0].map(|c| c * factor)).unwrap();
            assert!((x - 0.6).abs() < 1e-15 && y == 0.0 && (z + 0.8).abs() < 1e-15, "{factor}");
        }
        for none in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 1.0, 0.0]] {
            assert_eq!(unit(none), None, "{none:?}");
        }
    }
}
