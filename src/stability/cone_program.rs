//! The cone program that a round solves, by bodies and faces:
//!
//! min  q·u + Σ c τ  so that  l·u − Σ d τ = 1,  Gᵀu ≥ μ' τ at each corner,  ‖(Gᵀu)_t‖ ≤ τ for each face.
//!
//! Its unknowns x = (u, τ) are the velocities of bodies and how fast each face slides. Its dual variables are the largest load and the forces. All
//! rows but the first are those of a matrix M, and M x must be within cones. They stand face by face: corners, then (τ, (Gᵀu)_t) where it rubs.

use super::cone::Four;

/// The velocity of a body, or the force and moment on it.
pub(super) type Six = [f64; 6];

/// The cone program of a round.
pub(super) struct Program {
    /// q and l, by body.
    pub cost: Vec<Six>,
    pub load: Vec<Six>,
    pub faces: Vec<Face>,
}

/// The rows of a joint.
pub(super) struct Face {
    pub ends: [Option<usize>; 2],
    /// The resultant of a unit of each force on both bodies: the forces at the corners, then none or three of friction.
    pub rows: Vec<[Six; 2]>,
    pub corners: usize,
    /// μ'
    pub slope: f64,
    /// c and d.
    pub width: f64,
    pub grows: f64,
}

/// Numbers like the unknowns: six by body and one by face, which stays zero where it does not rub.
#[derive(Clone)]
pub(super) struct Motion {
    pub bodies: Vec<Six>,
    pub slides: Vec<f64>,
}

impl Face {
    pub fn rubs(&self) -> bool {
        self.rows.len() > self.corners
    }

    /// Rows of M.
    pub fn count(&self) -> usize {
        self.corners + if self.rubs() { 4 } else { 0 }
    }

    /// Those of friction among its numbers.
    pub fn four(&self, numbers: &[f64]) -> Four {
        std::array::from_fn(|i| numbers[self.corners + i])
    }

    /// A row of G times velocities.
    pub fn passes(&self, row: usize, velocities: &[Six]) -> f64 {
        let mut sum = 0.0;
        for (end, row) in self.ends.iter().zip(&self.rows[row]) {
            if let Some(body) = *end {
                let products = row.iter().zip(&velocities[body]).map(|(a, b)| a * b);
                sum += products.sum::<f64>();
            }
        }
        sum
    }

    /// Adds the effect of a force.
    pub fn push(&self, row: usize, force: f64, bodies: &mut [Six]) {
        for (end, row) in self.ends.iter().zip(&self.rows[row]) {
            if let Some(body) = *end {
                for (to, number) in bodies[body].iter_mut().zip(row) {
                    *to += force * number;
                }
            }
        }
    }
}

impl Program {
    /// q and c.
    pub fn costs(&self) -> Motion {
        Motion {
            bodies: self.cost.clone(),
            slides: self.faces.iter().map(|face| face.width).collect(),
        }
    }

    /// l and −d.
    pub fn loads(&self) -> Motion {
        Motion {
            bodies: self.load.clone(),
            slides: self.faces.iter().map(|face| -face.grows).collect(),
        }
    }

    /// Zero.
    pub fn still(&self) -> Motion {
        Motion {
            bodies: vec![[0.0; 6]; self.cost.len()],
            slides: vec![0.0; self.faces.len()],
        }
    }

    /// Faces, each with where its rows begin.
    pub fn starts(&self) -> impl Iterator<Item = (&Face, usize)> {
        self.faces.iter().scan(0, |next, face| {
            let start = *next;
            *next += face.count();
            Some((face, start))
        })
    }

    /// M x
    pub fn passes(&self, motion: &Motion) -> Vec<f64> {
        let mut passes = Vec::with_capacity(8 * self.faces.len());
        for (face, &slide) in self.faces.iter().zip(&motion.slides) {
            for row in 0..face.rows.len() {
                if row == face.corners {
                    passes.push(slide);
                }
                let passed = face.passes(row, &motion.bodies);
                passes.push(match row < face.corners {
                    true => passed - face.slope * slide,
                    false => passed,
                });
            }
        }
        passes
    }

    /// Mᵀ z
    pub fn pushes(&self, forces: &[f64]) -> Motion {
        let mut motion = self.still();
        let slides = &mut motion.slides;
        for ((face, start), slide) in self.starts().zip(slides) {
            let (corners, rubs) = forces[start..start + face.count()].split_at(face.corners);
            for (row, &force) in corners.iter().enumerate() {
                face.push(row, force, &mut motion.bodies);
                *slide -= face.slope * force;
            }
            if let [first, rest @ ..] = rubs {
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

    /// The largest of its numbers, whatever its sign.
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

    /// A multiple of it.
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
