//! The cone program of a round, in terms of bodies and faces:
//!
//! min  q·u + Σ c τ  so that  l·u − Σ d τ = 1,  Gᵀu ≥ μ' τ at each corner,  ‖(Gᵀu)_t‖ ≤ τ for each face.
//!
//! Its unknowns x = (u, τ) are the velocities of bodies and the sliding speed of each face. Its dual variables are the largest load and the
//! forces. All rows except the first form a matrix M, and M x must be within cones. The rows are ordered by face: first the corners, then
//! (τ, (Gᵀu)_t) if the face has friction.

use super::cone::Four;

/// The velocity of a body, or the force and moment on it.
pub(super) type Six = [f64; 6];

/// The cone program of a round.
pub(super) struct Program {
    /// q, by body.
    pub cost: Vec<Six>,
    /// l, by body.
    pub load: Vec<Six>,
    pub faces: Vec<Face>,
}

/// The rows of a joint.
pub(super) struct Face {
    pub ends: [Option<usize>; 2],
    /// Rows of Gᵀ: the resultant of a unit of each force on both bodies. First the forces at the corners, then three or no friction forces.
    pub rows: Vec<[Six; 2]>,
    pub corners: usize,
    /// μ', the slope of the friction cone.
    pub slope: f64,
    /// c, the width of the friction cone.
    pub width: f64,
    /// d, the increase of the width per unit of the load.
    pub growth: f64,
}

/// A vector of the space of the unknowns: six numbers for each body and one for each face, which is zero if the face has no friction.
#[derive(Clone)]
pub(super) struct Motion {
    pub bodies: Vec<Six>,
    pub slides: Vec<f64>,
}

impl Face {
    pub fn has_friction(&self) -> bool {
        self.rows.len() > self.corners
    }

    /// Number of its rows of M.
    pub fn count(&self) -> usize {
        self.corners + if self.has_friction() { 4 } else { 0 }
    }

    /// The numbers of the friction cone among those of its rows.
    pub fn four(&self, numbers: &[f64]) -> Four {
        std::array::from_fn(|i| numbers[self.corners + i])
    }

    /// The product of a row of Gᵀ and velocities.
    pub fn speed(&self, row: usize, velocities: &[Six]) -> f64 {
        let mut sum = 0.0;
        for (end, row) in self.ends.iter().zip(&self.rows[row]) {
            if let Some(body) = *end {
                let velocity = &velocities[body];
                (0..6).for_each(|i| sum += row[i] * velocity[i]);
            }
        }
        sum
    }

    /// Adds the resultant of a force to those of the bodies.
    pub fn push(&self, row: usize, force: f64, bodies: &mut [Six]) {
        for (end, row) in self.ends.iter().zip(&self.rows[row]) {
            if let Some(body) = *end {
                add_times(&mut bodies[body], force, row);
            }
        }
    }
}

/// Adds a multiple of six numbers. Counted loops over six numbers are fast in debug builds too, where pairs of iterators are not.
#[inline]
pub(super) fn add_times(to: &mut Six, times: f64, six: &Six) {
    (0..6).for_each(|i| to[i] += times * six[i]);
}

impl Program {
    /// The vector (q, c).
    pub fn costs(&self) -> Motion {
        Motion {
            bodies: self.cost.clone(),
            slides: self.faces.iter().map(|face| face.width).collect(),
        }
    }

    /// The vector (l, −d).
    pub fn loads(&self) -> Motion {
        Motion {
            bodies: self.load.clone(),
            slides: self.faces.iter().map(|face| -face.growth).collect(),
        }
    }

    /// The zero vector.
    pub fn zero(&self) -> Motion {
        Motion {
            bodies: vec![[0.0; 6]; self.cost.len()],
            slides: vec![0.0; self.faces.len()],
        }
    }

    /// The faces, each with the index of its first row.
    pub fn starts(&self) -> impl Iterator<Item = (&Face, usize)> {
        self.faces.iter().scan(0, |next, face| {
            let start = *next;
            *next += face.count();
            Some((face, start))
        })
    }

    /// The product M x.
    pub fn speeds(&self, motion: &Motion) -> Vec<f64> {
        let mut speeds = Vec::with_capacity(8 * self.faces.len());
        for (face, &slide) in self.faces.iter().zip(&motion.slides) {
            for row in 0..face.rows.len() {
                if row == face.corners {
                    speeds.push(slide);
                }
                let speed = face.speed(row, &motion.bodies);
                speeds.push(match row < face.corners {
                    true => speed - face.slope * slide,
                    false => speed,
                });
            }
        }
        speeds
    }

    /// The product Mᵀ z.
    pub fn resultants(&self, forces: &[f64]) -> Motion {
        let mut motion = self.zero();
        let slides = &mut motion.slides;
        for ((face, start), slide) in self.starts().zip(slides) {
            let (corners, friction) = forces[start..start + face.count()].split_at(face.corners);
            for (row, &force) in corners.iter().enumerate() {
                face.push(row, force, &mut motion.bodies);
                *slide -= face.slope * force;
            }
            if let [first, rest @ ..] = friction {
                *slide += first;
                for (row, &force) in (face.corners..).zip(rest) {
                    face.push(row, force, &mut motion.bodies);
                }
            }
        }
        motion
    }
}

impl Motion {
    fn numbers(&self) -> impl Iterator<Item = f64> {
        let bodies = self.bodies.as_flattened();
        bodies.iter().chain(&self.slides).copied()
    }

    pub fn dot(&self, other: &Self) -> f64 {
        self.numbers()
            .zip(other.numbers())
            .map(|(a, b)| a * b)
            .sum()
    }

    /// The largest absolute value of its numbers.
    pub fn largest(&self) -> f64 {
        self.numbers().map(f64::abs).fold(0.0, f64::max)
    }

    /// Adds a multiple of another.
    pub fn add(&mut self, times: f64, other: &Self) {
        let bodies = self.bodies.as_flattened_mut();
        for (to, number) in bodies
            .iter_mut()
            .chain(&mut self.slides)
            .zip(other.numbers())
        {
            *to += times * number;
        }
    }

    /// Returns a multiple of it.
    pub fn times(&self, times: f64) -> Self {
        Self {
            bodies: self
                .bodies
                .iter()
                .map(|six| six.map(|number| number * times))
                .collect(),
            slides: self.slides.iter().map(|number| number * times).collect(),
        }
    }
}
