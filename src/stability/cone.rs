//! Operations on the second-order cone ‖v‖ ≤ t of four numbers (t, v) that an interior-point method needs: products, the distance to the
//! boundary, and the scaling.

/// The numbers t and v, in this order.
pub(super) type Four = [f64; 4];

pub(super) fn dot(one: Four, other: Four) -> f64 {
    (0..4).map(|i| one[i] * other[i]).sum()
}

/// t² − ‖v‖², without cancellation near the boundary of the cone.
fn square(of: Four) -> f64 {
    let length = (of[1] * of[1] + of[2] * of[2] + of[3] * of[3]).sqrt();
    (of[0] - length) * (of[0] + length)
}

/// Jordan's product x ∘ y.
pub(super) fn product(one: Four, other: Four) -> Four {
    let of = |i: usize| one[0] * other[i] + other[0] * one[i];
    [dot(one, other), of(1), of(2), of(3)]
}

/// Jordan's quotient: the x for which x ∘ `by` = `of`.
pub(super) fn quotient(of: Four, by: Four) -> Four {
    let inner = by[1] * of[1] + by[2] * of[2] + by[3] * of[3];
    let first = (by[0] * of[0] - inner) / square(by);
    let rest = |i: usize| (of[i] - first * by[i]) / by[0];
    [first, rest(1), rest(2), rest(3)]
}

/// Distance along a direction from a point of the cone to its boundary.
pub(super) fn reach(from: Four, along: Four) -> f64 {
    // Along the way t² − ‖v‖² is a α² + 2 b α + c.
    let a = square(along);
    let c = square(from).max(0.0);
    let b = 2.0 * from[0] * along[0] - dot(from, along);
    let inner = b * b - a * c;
    if inner < 0.0 {
        return f64::INFINITY;
    }
    // Its two zeros, by the formula without cancellation. The result is the smallest that is not negative.
    let far = -b - inner.sqrt().copysign(b);
    let ahead = [c / far, far / a].into_iter().filter(|&at| at >= 0.0);
    ahead.fold(f64::INFINITY, f64::min)
}

/// The scaling of Nesterov and Todd: the symmetric matrix W with W z = W⁻¹ s.
#[derive(Clone, Copy, Default)]
pub(super) struct Scaling {
    /// The factor η.
    pub size: f64,
    /// The scaling point, which has t² − ‖v‖² = 1.
    pub point: Four,
}

impl Scaling {
    /// The scaling of two points inside the cone.
    pub fn new(s: Four, z: Four) -> Self {
        let [far, worth] = [square(s).max(1e-300).sqrt(), square(z).max(1e-300).sqrt()];
        let mean = 0.5 + 0.5 * dot(s, z) / (far * worth);
        let share = 0.5 / mean.sqrt();
        let of = |i: usize| share * (s[i] / far - z[i] / worth);
        let [x, y, z] = [of(1), of(2), of(3)];
        Self {
            size: (far / worth).sqrt(),
            point: [(1.0 + x * x + y * y + z * z).sqrt(), x, y, z],
        }
    }

    /// Multiplies by W; with sign −1 and size 1/η, by W⁻¹.
    fn apply(&self, of: Four, sign: f64, size: f64) -> Four {
        let [t, x, y, z] = self.point;
        let inner = x * of[1] + y * of[2] + z * of[3];
        let share = sign * of[0] + inner / (1.0 + t);
        let first = t * of[0] + sign * inner;
        [
            first * size,
            (of[1] + share * x) * size,
            (of[2] + share * y) * size,
            (of[3] + share * z) * size,
        ]
    }

    /// Returns W x.
    pub fn times(&self, of: Four) -> Four {
        self.apply(of, 1.0, self.size)
    }

    /// Returns W⁻¹ x.
    pub fn inverse(&self, of: Four) -> Four {
        self.apply(of, -1.0, 1.0 / self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: Four = [3.0, 1.0, -2.0, 0.5];
    const Z: Four = [1.5, 0.3, 0.2, -1.2];

    fn assert_same(one: Four, other: Four) {
        let off = (0..4).map(|i| (one[i] - other[i]).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12, "{one:?} and {other:?}");
    }

    #[test]
    fn a_scaling_maps_both_points_to_one_point() {
        let scaling = Scaling::new(S, Z);
        assert_same(scaling.times(Z), scaling.inverse(S));
        assert_same(scaling.times(scaling.inverse(S)), S);
    }

    #[test]
    fn a_quotient_undoes_a_product() {
        assert_same(quotient(product(S, Z), S), Z);
    }

    #[test]
    fn reach_ends_at_the_boundary() {
        for along in [
            [-1.0, 0.0, 0.0, 0.0],
            [0.1, 5.0, 0.0, 1.0],
            [-1.0, 0.2, 0.1, 0.0],
        ] {
            let far = reach(S, along);
            let at: Four = std::array::from_fn(|i| S[i] + far * along[i]);
            assert!(at[0] >= 0.0 && square(at).abs() < 1e-12, "{at:?}");
        }
        assert_eq!(reach(S, [1.0, 0.0, 0.0, 0.0]), f64::INFINITY);
    }
}
