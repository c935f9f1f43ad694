//! The forces in the bonds of a structure under loads on its bodies.
//!
//! Statics alone does not say what each of several bonds bears that hold each other, such as those of a wall. Their stiffness does: a bond
//! is as stiff as its area is large ([`Section::stiffness`]). So bonds are springs between their bodies, and forces follow from the
//! displacements u of bodies, K u = p, with K the stiffness of all bonds and p the loads. K depends only on how bodies and bonds lie
//! relative to each other, so it is factorized once, in the axes of the first body, and serves until a bond breaks.
//!
//! A structure that nothing holds is held at its first body; its loads are in equilibrium, so that gets no force.

use super::structure::{Bond, FIXED, Place};
use crate::Both;
use crate::joint::is_angular;
use crate::lanes::{PlainKernel, run_plain};
use crate::patches::soft_step::joints::factor::{Coupling, Factor, Numbers};
use crate::patches::soft_step::joints::springs::{Springs, quad};
use glam::DVec3;

/// Force and moment of a bond on its second body at the anchor there, in the axes of the bond; or impulses.
pub type BondForce = [DVec3; 2];

/// A bond as springs.
#[derive(Clone, Debug)]
struct Spring {
    /// The places of its bodies that move.
    places: [Option<usize>; 2],
    coupling: Option<Coupling>,
    arms: [DVec3; 2],
    axes: [DVec3; 3],
    /// Against its coordinates, relative to a stiffness of 1 per area.
    stiffness: [f64; 6],
}

/// The stiffness of a structure.
#[derive(Debug)]
pub struct Stiffness {
    springs: Vec<Spring>,
    factor: Factor,
    /// Whether it was factorized with fused operations; `None` if it was not factorized yet.
    factorized: Option<bool>,
    unknowns: Vec<Numbers>,
}

/// The stiffness of bonds between bodies at places.
pub fn stiffness(bonds: &[Bond], places: &[Place]) -> Stiffness {
    let moving = |end: usize| (end != FIXED).then_some(end);
    let both = |bond: &Bond| Some([moving(bond.ends[0])?, moving(bond.ends[1])?]);
    let edges: Vec<[usize; 2]> = bonds.iter().filter_map(both).collect();
    let factor = Factor::new(places.len(), &edges);
    let springs = bonds.iter().map(|bond| {
        let (axes, arms) = bond.geometry(places);
        Spring {
            places: bond.ends.both(|end| Some(factor.place_of(moving(end)?))),
            coupling: both(bond).map(|ends| factor.coupling(ends)),
            arms,
            axes,
            stiffness: [0, 1, 2, 3, 4, 5].map(|i| f64::from(bond.section().stiffness(i))),
        }
    });
    Stiffness {
        springs: springs.collect(),
        unknowns: vec![Numbers::default(); places.len()],
        factorized: None,
        factor,
    }
}

impl Stiffness {
    /// The forces of bonds under loads on bodies: a force and a moment about the centre of mass for each, in the axes of the first one.
    pub fn forces(
        &mut self,
        loads: &[[DVec3; 2]],
        is_held: bool,
        is_fused: bool,
        to: &mut Vec<BondForce>,
    ) {
        if self.factorized != Some(is_fused) {
            self.assemble(is_held);
            run_plain(is_fused, Factorize(&mut self.factor));
            self.factorized = Some(is_fused);
        }
        for (body, load) in loads.iter().enumerate() {
            self.unknowns[self.factor.place_of(body)] = load.both(quad);
        }
        run_plain(is_fused, self.factor.solve(&mut self.unknowns));
        to.clear();
        to.extend(self.springs.iter().map(|spring| {
            let [a, b] = spring.places.both(|place| match place {
                Some(place) => self.unknowns[place].both(|[x, y, z, _]| DVec3::new(x, y, z)),
                None => [DVec3::ZERO; 2],
            });
            let [one, other] = spring.arms;
            let along = (b[0] + b[1].cross(other)) - (a[0] + a[1].cross(one));
            let about = b[1] - a[1];
            let pull = |i: usize| {
                let change = if is_angular(i) { about } else { along };
                -spring.stiffness[i] * spring.axes[i % 3].dot(change)
            };
            [
                DVec3::new(pull(0), pull(1), pull(2)),
                DVec3::new(pull(3), pull(4), pull(5)),
            ]
        }));
    }

    fn assemble(&mut self, is_held: bool) {
        self.factor.clear();
        for spring in &self.springs {
            let matrix = |first: usize| {
                let along = |j: usize| {
                    let sum = (0..3)
                        .map(|i| spring.stiffness[first + i] * spring.axes[i][j] * spring.axes[i]);
                    quad(sum.sum())
                };
                [along(0), along(1), along(2)]
            };
            let springs = Springs::new::<false>([matrix(0), matrix(3)], spring.arms);
            for (side, place) in spring.places.into_iter().enumerate() {
                if let Some(place) = place {
                    springs.add_to::<false>(self.factor.pivot(place), [side; 2]);
                }
            }
            if let Some(coupling) = spring.coupling {
                let (block, is_transposed) = self.factor.coupled(coupling);
                let sides = if is_transposed { [1, 0] } else { [0, 1] };
                springs.add_to::<false>(block, sides);
            }
        }
        if !is_held {
            let first = self.factor.place_of(0);
            for (i, column) in self.factor.pivot(first).iter_mut().enumerate() {
                column[i / 3][i % 3] *= 2.0;
            }
        }
    }
}

/// A factorization as a kernel.
struct Factorize<'a>(&'a mut Factor);

impl PlainKernel for Factorize<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        self.0.factorize::<FUSED>(false);
    }
}
