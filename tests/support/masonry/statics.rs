//! Limit analysis of masonry: does any set of contact forces keep rigid blocks in equilibrium? Heyman's safe theorem as a linear
//! program, with friction bounded by Coulomb's cone, which in the plane is exact.

use crate::masonry::blocks::{Joint, Masonry};
use glam::DVec2;
use microlp::{ComparisonOp, Error, OptimizationDirection, Problem, Variable};

/// Forces at the centres of mass of all blocks, in weights of all that is free.
type Loads = Vec<DVec2>;

/// The weights of all blocks towards there.
pub fn weights(masonry: &Masonry, direction: DVec2) -> Loads {
    let free = masonry.blocks.iter().filter(|block| !block.fixed);
    let all: f64 = free.map(|block| block.mass()).sum();
    let weight = |block: &crate::masonry::blocks::Block| block.mass() / all * direction;
    masonry.blocks.iter().map(weight).collect()
}

/// The equations of a program: for each free block the sums of forces along x and y and of moments about its centre.
struct Balance(Vec<[Vec<(Variable, f64)>; 3]>);

impl Balance {
    /// A force of unknown size on a block.
    fn add(&mut self, block: usize, force: Variable, direction: DVec2, arm: DVec2) {
        let [x, y, moment] = &mut self.0[block];
        x.push((force, direction.x));
        y.push((force, direction.y));
        moment.push((force, arm.perp_dot(direction)));
    }
}

/// Unknown forces that keep all in equilibrium.
struct Program {
    problem: Problem,
    balance: Balance,
}

impl Program {
    /// Under some loads and any multiple of `more`, which is to be as large as it can; or, with mortar, with as little of that as it can.
    fn new(masonry: &Masonry, always: &Loads, more: &Loads, mortar: bool) -> Self {
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let factor = (!mortar).then(|| problem.add_var(1.0, (0.0, f64::INFINITY)));
        let balance = Balance(vec![Default::default(); masonry.blocks.len()]);
        let mut program = Self { problem, balance };
        for joint in masonry.joints() {
            for end in joint.ends {
                program.push(masonry, &joint, end, mortar);
            }
        }
        let sums = std::mem::take(&mut program.balance.0);
        let free = |i: &usize| !masonry.blocks[*i].fixed;
        for (i, sums) in sums.into_iter().enumerate().filter(|(i, _)| free(i)) {
            let loads = [
                (always[i].x, more[i].x),
                (always[i].y, more[i].y),
                (0.0, 0.0),
            ];
            for (mut sum, (always, more)) in sums.into_iter().zip(loads) {
                sum.retain(|(_, share)| share.abs() > 1e-12);
                sum.extend(factor.filter(|_| more != 0.0).map(|factor| (factor, more)));
                program
                    .problem
                    .add_constraint(&sum, ComparisonOp::Eq, -always);
            }
        }
        program
    }

    /// The forces at one end of a joint.
    fn push(&mut self, masonry: &Masonry, joint: &Joint, end: DVec2, mortar: bool) {
        let (any, some) = ((f64::NEG_INFINITY, f64::INFINITY), (0.0, f64::INFINITY));
        let normal = self.problem.add_var(0.0, some);
        let friction = self.problem.add_var(0.0, any);
        let mortar = mortar.then(|| self.problem.add_var(-1.0, some));
        for side in [-1.0, 1.0] {
            let mut cone = vec![(friction, side), (normal, -masonry.friction)];
            cone.extend(mortar.map(|mortar| (mortar, -1.0)));
            self.problem.add_constraint(&cone, ComparisonOp::Le, 0.0);
        }
        for (block, sign) in joint.blocks.into_iter().zip([1.0, -1.0]) {
            let arm = end - masonry.blocks[block].center();
            let toward = sign * joint.normal;
            self.balance.add(block, normal, toward, arm);
            self.balance.add(block, friction, toward.perp(), arm);
            if let Some(mortar) = mortar {
                self.balance.add(block, mortar, -toward, arm);
            }
        }
    }

    /// The maximum of the objective, if there is a solution.
    fn solve(self) -> Option<f64> {
        match self.problem.solve() {
            Ok(outcome) => {
                let solution = outcome.into_solution().expect("there is no limit of time");
                Some(solution.objective())
            }
            Err(Error::Unbounded) => Some(f64::INFINITY),
            Err(Error::Infeasible) => None,
            Err(error) => panic!("{error}"),
        }
    }
}

/// The largest factor of `more` with which there is equilibrium under `always` and it; infinite where there is one with any;
/// nothing where there is none even with 0.
fn most(masonry: &Masonry, always: &Loads, more: &Loads) -> Option<f64> {
    Program::new(masonry, always, more, false).solve()
}

/// Whether it can stand under its weight.
///
/// If only the sign of a limit is needed, a program may have no solution, which would have to be proved. This program always has one: the
/// least tension that mortar in the joints would have to bear, which is zero if the structure stands.
pub fn stands(masonry: &Masonry) -> bool {
    let nothing = vec![DVec2::ZERO; masonry.blocks.len()];
    let program = Program::new(masonry, &weights(masonry, DVec2::NEG_Y), &nothing, true);
    program.solve().expect("mortar holds all") > -1e-9
}

/// The angle by which it can be turned towards −x until it no longer stands, rad; π/2 where it stands at any.
pub fn limit_tilt(masonry: &Masonry) -> f64 {
    let [down, across] = [DVec2::NEG_Y, DVec2::NEG_X].map(|way| weights(masonry, way));
    let tangent = most(masonry, &down, &across).expect("it stands upright");
    tangent.atan()
}

/// The largest additional weight of one block, as a multiple of its weight.
pub fn limit_load(masonry: &Masonry, block: usize) -> f64 {
    let always = weights(masonry, DVec2::NEG_Y);
    let mut more = vec![DVec2::ZERO; masonry.blocks.len()];
    more[block] = always[block];
    1.0 + most(masonry, &always, &more).expect("it stands as it is")
}

/// The parameter at which something begins to stand, to 1e-6 of the way.
pub fn threshold(falls: f64, stands: f64, of: impl Fn(f64) -> Masonry) -> f64 {
    let (mut low, mut high) = (falls, stands);
    assert!(!self::stands(&of(low)), "must fall at {low}");
    assert!(self::stands(&of(high)), "must stand at {high}");
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if self::stands(&of(middle)) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}
