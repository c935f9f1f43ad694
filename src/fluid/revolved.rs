//! Balls, cylinders, cones and capsules that a surface cuts: solids of revolution, in discs across their axis.

use super::wet::{Around, Wet, ball_volume};
use crate::solver::sort;
use bevy_math::ops;
use glam::Vec3;
use smallvec::SmallVec;
use std::f32::consts::PI;

/// Places and weights of a Gauss–Legendre rule on (−1, 1).
const RULE: [(f32, f32); 5] = [
    (-0.906_179_85, 0.236_926_89),
    (-0.538_469_3, 0.478_628_67),
    (0.0, 0.568_888_9),
    (0.538_469_3, 0.478_628_67),
    (0.906_179_85, 0.236_926_89),
];

/// Drag of a ball, as a share of that of its disc.
const BALL_DRAG: f32 = 0.5;

/// Drag of the side of a long cylinder, as a share of that of a plate in its place.
const SIDE_DRAG: f32 = 2.0 / 3.0;

/// A solid of revolution.
pub(super) struct Revolved {
    pieces: SmallVec<[Piece; 3]>,
    volume: f32,
    /// Area times drag coefficient of the two ends, as they are seen along the axis, m²: that which moves ahead along the axis, and against
    /// it.
    ends: [f32; 2],
}

/// A piece of the axis, on which the square of the radius is a polynomial of the place.
struct Piece {
    from: f32,
    to: f32,
    /// r² = k₀ + k₁ s + k₂ s², m².
    radius: [f32; 3],
}

impl Piece {
    fn radius_squared(&self, s: f32) -> f32 {
        let [k0, k1, k2] = self.radius;
        (k0 + s * (k1 + s * k2)).max(0.0)
    }
}

impl Revolved {
    pub fn cylinder(radius: f32, half: f32) -> Self {
        let disc = PI * radius * radius;
        Self {
            pieces: [Piece::straight(radius, half)].into_iter().collect(),
            volume: 2.0 * half * disc,
            ends: [disc; 2],
        }
    }

    /// Its tip is ahead along the axis.
    pub fn cone(radius: f32, half: f32) -> Self {
        // r = slope · (half − s).
        let slope = 0.5 * radius / half;
        let square = slope * slope;
        let disc = PI * radius * radius;
        Self {
            pieces: [Piece {
                from: -half,
                to: half,
                radius: [square * half * half, -2.0 * square * half, square],
            }]
            .into_iter()
            .collect(),
            volume: 2.0 / 3.0 * half * disc,
            // The square of the sine of the angle at which the flow meets its side.
            ends: [disc * square / (1.0 + square), disc],
        }
    }

    pub fn capsule(radius: f32, half: f32) -> Self {
        let disc = PI * radius * radius;
        let cap = |from: f32, to: f32, center: f32| Piece {
            from,
            to,
            radius: [radius * radius - center * center, 2.0 * center, -1.0],
        };
        Self {
            pieces: [
                cap(-half - radius, -half, -half),
                Piece::straight(radius, half),
                cap(half, half + radius, half),
            ]
            .into_iter()
            .collect(),
            volume: 2.0 * half * disc + ball_volume(radius),
            ends: [BALL_DRAG * disc; 2],
        }
    }

    /// Adds what is wet of it, with its centre in a place and along a unit axis.
    pub fn add(&self, wet: &mut Wet, center: Vec3, axis: Vec3, around: &Around) {
        let before = wet.volume;
        let cut = Cut::new(center, axis, around);
        for piece in &self.pieces {
            let ends = cut.ends(piece);
            for [from, to] in ends.array_windows() {
                cut.add_between(wet, piece, *from, *to, around);
            }
        }
        let share = (wet.volume - before) / self.volume;
        let along = around.flow_at(center).dot(axis);
        let end = self.ends[usize::from(along < 0.0)];
        let force = -around.pressure * share * end * along * along.abs();
        wet.add_force(force * axis, center);
    }
}

impl Piece {
    fn straight(radius: f32, half: f32) -> Self {
        Self {
            from: -half,
            to: half,
            radius: [radius * radius, 0.0, 0.0],
        }
    }
}

/// How the surface of the fluid cuts the discs across an axis.
struct Cut {
    center: Vec3,
    axis: Vec3,
    /// Unit direction in a disc, out of the fluid.
    out: Vec3,
    /// Sine of the angle between the axis and the normal of the surface.
    sine: f32,
    /// Depth of the centre of the disc at s: d₀ + d₁ s.
    depth: [f32; 2],
}

impl Cut {
    fn new(center: Vec3, axis: Vec3, around: &Around) -> Self {
        let along = around.normal.dot(axis);
        let out = around.normal - along * axis;
        let sine = out.length();
        Self {
            center,
            axis,
            out: out.normalize_or_zero(),
            sine,
            depth: [around.depth(center), -along],
        }
    }

    /// The ends of a piece, and the places between them where the discs begin or cease to be cut.
    fn ends(&self, piece: &Piece) -> SmallVec<[f32; 4]> {
        let [d0, d1] = self.depth;
        let square = self.sine * self.sine;
        let [k0, k1, k2] = piece.radius;
        // (d₀ + d₁ s)² = sine² r²
        let [c, half_b, a] = [
            d0 * d0 - square * k0,
            d0 * d1 - 0.5 * square * k1,
            d1 * d1 - square * k2,
        ];
        let mut ends: SmallVec<[f32; 4]> = [piece.from, piece.to].into_iter().collect();
        let under = half_b * half_b - a * c;
        if under >= 0.0 {
            let root = under.sqrt();
            // Without cancellation.
            let q = -(half_b + root * half_b.signum());
            for s in [q / a, c / q] {
                if piece.from < s && s < piece.to {
                    ends.push(s);
                }
            }
        }
        sort::values(&mut ends);
        ends
    }

    /// Adds the wet parts of the discs between two places.
    fn add_between(&self, wet: &mut Wet, piece: &Piece, from: f32, to: f32, around: &Around) {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        for (place, weight) in RULE {
            let s = middle + half * place;
            let square = piece.radius_squared(s);
            let radius = square.sqrt();
            let depth = self.depth[0] + self.depth[1] * s;
            // The disc is wet up to here along `out`.
            let level = if depth.abs() >= self.sine * radius {
                radius.copysign(depth)
            } else {
                depth / self.sine
            };
            if level <= -radius {
                continue;
            }
            let chord = (square - level * level).max(0.0);
            let angle = ops::asin((level / radius).clamp(-1.0, 1.0));
            let area = square * (0.5 * PI + angle) + level * chord.sqrt();
            let first = -2.0 / 3.0 * chord * chord.sqrt();
            let at = self.center + s * self.axis;
            let length = weight * half;
            wet.volume += length * area;
            wet.moment += length * (area * at + first * self.out);
            let flow = around.flow_at(at);
            let across = flow - flow.dot(self.axis) * self.axis;
            let seen = SIDE_DRAG * 2.0 * radius * length * (area / (PI * square));
            wet.add_force(-around.pressure * seen * across.length() * across, at);
        }
    }
}

/// Adds what is wet of a ball.
pub(super) fn add_ball(wet: &mut Wet, center: Vec3, radius: f32, around: &Around) {
    let wet_height = (around.depth(center) + radius).clamp(0.0, 2.0 * radius);
    if wet_height == 0.0 {
        return;
    }
    let volume = PI * wet_height * wet_height * (radius - wet_height / 3.0);
    let rest = 2.0 * radius - wet_height;
    let below = 0.75 * rest * rest / (3.0 * radius - wet_height);
    wet.add_volume(volume, center - below * around.normal);
    let flow = around.flow_at(center);
    let seen = BALL_DRAG * PI * radius * radius * (volume / ball_volume(radius));
    wet.add_force(-around.pressure * seen * flow.length() * flow, center);
}
