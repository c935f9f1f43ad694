//! Masonry of one thickness: blocks drawn in a plane, in double precision. The same drawing is used by statics and is built and simulated.

use glam::{DMat2, DQuat, DVec2, DVec3};

/// A convex outline, counter-clockwise, m, about z = 0.
#[derive(Clone, Debug)]
pub struct Block {
    pub outline: Vec<DVec2>,
    /// Its extent along z, m.
    pub depth: f64,
    /// kg/m³
    pub density: f64,
    pub fixed: bool,
}

impl Block {
    pub fn new(outline: &[DVec2]) -> Self {
        Self {
            outline: outline.to_vec(),
            depth: 1.0,
            density: 1000.0,
            fixed: false,
        }
    }

    /// Upright, with its lower left corner there.
    pub fn rectangle(corner: DVec2, size: DVec2) -> Self {
        let [x, y] = [DVec2::X * size.x, DVec2::Y * size.y];
        Self::new(&[corner, corner + x, corner + x + y, corner + y])
    }

    /// It does not move, and is deeper than what touches it, so that the joints are as deep as that.
    pub fn fixed(mut self) -> Self {
        self.fixed = true;
        self.depth = 4.0;
        self
    }

    pub fn edges(&self) -> impl Iterator<Item = [DVec2; 2]> {
        let next = self.outline.iter().cycle().skip(1);
        self.outline.iter().zip(next).map(|(&a, &b)| [a, b])
    }

    /// m²
    fn area(&self) -> f64 {
        self.edges().map(|[a, b]| 0.5 * a.perp_dot(b)).sum()
    }

    /// kg
    pub fn mass(&self) -> f64 {
        self.density * self.area() * self.depth
    }

    /// The centre of mass.
    pub fn center(&self) -> DVec2 {
        // About a corner, which loses nothing to rounding far from the origin.
        let origin = self.outline[0];
        let moment: DVec2 = self
            .edges()
            .map(|[a, b]| [a - origin, b - origin])
            .map(|[a, b]| a.perp_dot(b) * (a + b) / 6.0)
            .sum();
        origin + moment / self.area()
    }

    /// How its own x axis lies in the drawing: along its first edge.
    pub fn turn(&self) -> f64 {
        (self.outline[1] - self.outline[0]).to_angle()
    }

    /// The corners in its own frame, at its centre of mass.
    pub fn corners(&self) -> Vec<DVec3> {
        let (back, center) = (DMat2::from_angle(-self.turn()), self.center());
        let at = |z: f64| {
            let corner = move |&p: &DVec2| (back * (p - center)).extend(z);
            self.outline.iter().map(corner)
        };
        at(-0.5 * self.depth).chain(at(0.5 * self.depth)).collect()
    }

    /// Its length, height and depth, where it is a rectangle.
    pub fn cuboid(&self) -> Option<DVec3> {
        let sides: Vec<DVec2> = self.edges().map(|[a, b]| b - a).collect();
        let [x, y, ..] = sides[..] else { return None };
        let right = x.dot(y).abs() < 1e-12 * x.length() * y.length();
        let closes = sides.len() == 4 && (sides[2] + x).length() < 1e-12 * x.length();
        (right && closes).then(|| DVec3::new(x.length(), y.length(), self.depth))
    }
}

/// A straight line along which two blocks meet exactly.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    /// Indices of A and B.
    pub blocks: [usize; 2],
    /// From B to A.
    pub normal: DVec2,
    pub ends: [DVec2; 2],
    /// m
    pub depth: f64,
}

/// Blocks and the friction between them.
#[derive(Clone, Debug)]
pub struct Masonry {
    pub blocks: Vec<Block>,
    /// μ of all joints.
    pub friction: f64,
}

/// Lines no further apart than this are one, m.
const EXACT: f64 = 1e-9;

impl Masonry {
    /// Its last block so many times as heavy.
    pub fn loaded(mut self, factor: f64) -> Self {
        let last = self.blocks.last_mut().expect("it has blocks");
        last.density *= factor;
        self
    }

    /// All joints except those between two fixed blocks.
    pub fn joints(&self) -> Vec<Joint> {
        let mut joints = Vec::new();
        for (i, a) in self.blocks.iter().enumerate() {
            for (j, b) in self.blocks.iter().enumerate().take(i) {
                if !(a.fixed && b.fixed) {
                    joints.extend(meet(a, b).map(|(normal, ends)| Joint {
                        blocks: [i, j],
                        normal,
                        ends,
                        depth: a.depth.min(b.depth),
                    }));
                }
            }
        }
        joints
    }

    /// The corners of a joint in the drawing.
    pub fn joint_corners(joint: &Joint) -> [DVec3; 4] {
        let [a, b] = joint.ends;
        let z = 0.5 * joint.depth;
        [a.extend(-z), a.extend(z), b.extend(-z), b.extend(z)]
    }
}

/// The normal towards A and the ends of the line along which two blocks meet.
fn meet(a: &Block, b: &Block) -> Option<(DVec2, [DVec2; 2])> {
    let pairs = a
        .edges()
        .flat_map(|of_a| b.edges().map(move |of_b| (of_a, of_b)));
    pairs.into_iter().find_map(|([from, to], of_b)| {
        let along = (to - from).normalize();
        let off = |p: DVec2| along.perp_dot(p - from).abs();
        let facing = along.dot(of_b[1] - of_b[0]) < 0.0;
        if !facing || of_b.into_iter().any(|p| off(p) > EXACT) {
            return None;
        }
        let [end, start] = of_b.map(|p| along.dot(p - from));
        let (start, end) = (start.max(0.0), end.min((to - from).length()));
        // The inside of an outline is to the left of its edges.
        (end - start > 1e-3).then(|| (along.perp(), [start, end].map(|s| from + s * along)))
    })
}

/// How a drawing stands in the world: turned in its plane against gravity, then about the vertical.
#[derive(Clone, Copy, Debug, Default)]
pub struct Frame {
    /// Tilt, rad. The up direction of the drawing leans towards −x.
    pub tilt: f64,
    /// rad
    pub yaw: f64,
}

impl Frame {
    pub fn rotation(&self) -> DQuat {
        DQuat::from_rotation_y(self.yaw) * DQuat::from_rotation_z(self.tilt)
    }
}
