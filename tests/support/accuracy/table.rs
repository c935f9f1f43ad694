//! All measurements, for the document.

use super::*;

/// A measurement for the document.
pub struct Case {
    /// Its heading.
    pub title: &'static str,
    /// What it does with a solver at a step of so many seconds.
    pub measure: fn(Settings, f32) -> Values,
    /// Whether it is cheap enough for the short form.
    pub quick: bool,
    /// Whether it is cheap enough for the shortest step.
    pub finest: bool,
    /// Whether it is measured with all solvers, or with the default one alone.
    pub solved: bool,
    /// Causes of what is missed.
    pub note: &'static str,
}

/// A measurement at all steps.
const fn case(
    title: &'static str,
    measure: fn(Settings, f32) -> Values,
    note: &'static str,
) -> Case {
    Case {
        title,
        measure,
        quick: true,
        finest: true,
        solved: true,
        note,
    }
}

/// In the order of the table of reference values.
pub static CASES: [Case; 35] = [
    case("1: slab starts to slide", slides, ""),
    case("2: slab slides down", slides_down, ""),
    case(
        "3: slab stops",
        stops,
        "The point solvers (NNCG, PGS) take a step at once: semi-implicit Euler brakes half a step early, which shortens the way by v \
         Δt/2 (0.25 m at 0.1 s, 4 cm at 1/60 s). Soft Step divides a step into substeps.",
    ),
    case("4: bodies roll", rolls, ""),
    case("4: bodies roll and slip", rollers_slip, ""),
    case("5: sphere slides into rolling", slides_into_rolling, ""),
    case("6: tower topples", topples, ""),
    case("7: pushed body tips", tips, ""),
    case("8: three logs", logs_stand, ""),
    case("9: four spheres", spheres_stand, ""),
    Case {
        finest: false,
        ..case("10: overhang", overhangs, "")
    },
    Case {
        quick: false,
        finest: false,
        ..case(
            "11: arch",
            arch_stands,
            "NNCG and PGS stop after 300 iterations, which at 0.1 s is not enough for an arch of 25. At μ 0.3092, where the range of \
             thicknesses that stand is narrow, they find none that stands; whether for want of iterations has not been examined.",
        )
    },
    Case {
        quick: false,
        ..case("12: ring slides and spins", ring_slides_and_spins, "")
    },
    Case {
        quick: false,
        ..case(
            "12: disk and cylinder slide and spin",
            disk_slides_and_spins,
            "Disk: the formula assumes uniform pressure. Statics does not say how 91 rigid feet share the weight, and each solver finds \
             another answer (see 13: disk). Cylinder: its manifold has four points on its rim. Under Soft Step a patch has one friction \
             force and one twisting moment, each with a bound of its own that does not know of the other: sliding takes v/(μ g), \
             spinning ω R/(2 μ g), as if each were alone, and the ratio is exactly ½. `none`: no ratio stays, or the motion has not \
             ended after 6 s.",
        )
    },
    case("13: spin slows", spin_slows, ""),
    case(
        "13: disk spins",
        disk_spin_slows,
        "Uniform pressure is an assumption of the formula, not a consequence of statics. With the pressure that the solver found, the \
         deceleration is right.",
    ),
    case(
        "14: rocking block",
        rocks,
        "Housner's formula is that of an impact in no time at the far edge alone. NNCG and PGS take lever arms at the start of a step, so \
         that a block loses energy while it swings, and stop the far edge in two steps: in the first so that it just arrives, in the \
         second altogether. Both errors fall with the step. Soft Step divides a step into substeps, 720 a second, and has the arms of the \
         middle of the step; see 21 for means over impacts.",
    ),
    case(
        "15: jerked base",
        base_slips,
        "NNCG and PGS: semi-implicit Euler, as in row 3, by V Δt/2.",
    ),
    case("16: ladder", ladder_slips, ""),
    case(
        "17: bounces",
        bounces,
        "A bounce happens a step early or late, which changes the speed by up to g Δt. Heights are squares of it, and errors add up. The \
         tests assert it at 1/1000 s.",
    ),
    case("18: stack at rest", stack_carries, ""),
    Case {
        solved: false,
        ..case("19: free brick", tumbles, "")
    },
    Case {
        solved: false,
        ..case("20: projectile", flies, "")
    },
    case(
        "20: closed group",
        group_keeps_momentum,
        "Soft Step divides a step into substeps, but the lever arms of a contact are fixed during a step; see *Angular momentum of \
         collisions* below.",
    ),
    Case {
        solved: false,
        ..case(
            "21: motion: blocks that rock",
            rocks_on,
            "Truth: Runge and Kutta's method in double precision, with Housner's impact. Single impacts are off by up to 1 %, \
             either way, by when they come within a substep. At 0.1 s a block turns by 5° in a step.",
        )
    },
    Case {
        solved: false,
        ..case(
            "22: motion: shaken floors",
            shakes,
            "The floor is kinematic and gets the mean velocity of each step. Where its acceleration goes on from step to step, its \
             velocity ramps within a step. An anchor gives way by a millimetre before it slides, so boxes that slide and stick \
             again and again are drawn back by up to that much each time.",
        )
    },
    Case {
        solved: false,
        ..case(
            "23: motion: spawned while sliding",
            slides_from_the_start,
            "The largest difference within 0.3 s. The box of 0.1 m/s stops after 0.0255 s and swings back on its springs by less than \
             0.4 mm/s.",
        )
    },
    Case {
        solved: false,
        ..case(
            "24: motion: rods that bounce",
            rods_bounce,
            "The worst of five phases of a step, after the step of the hit.",
        )
    },
    Case {
        solved: false,
        ..case(
            "25: motion: blocks that rock elsewhere",
            rocks_elsewhere,
            "As 21. For a block of 5 cm a step of 1/60 s is as long as one of 0.075 s for a block of 1 m.",
        )
    },
    Case {
        solved: false,
        ..case(
            "26: motion: what rocks as a whole",
            rocks_together,
            "The reference is the same solver at 1/1920 s; a block in one piece swings back by 0.777. Springs of a column store a part of \
             the impact and give it back: with more joints more, with shorter substeps less.",
        )
    },
    case("Hit of two bodies", hits, ""),
    case(
        "Hit with friction",
        grazes,
        "The worst of five phases of a step in which the ball arrives. Friction in the step of the hit is a little low \
         under Soft Step. NNCG and PGS: the contact is solved while the ball is \
             still up to v Δt away, and its lever arm is longer than the radius by that.",
    ),
    Case {
        quick: false,
        finest: false,
        ..case(
            "Impact on a stack",
            impacts,
            "The reference is the same solver at 1/1920 s. The ball at the foot of a column is a hit with friction on many contacts at \
             once, whose outcome the laws of rigid bodies do not determine: Soft Step and the point solvers converge to different values.",
        )
    },
    Case {
        quick: false,
        ..case(
            "Chain in a catenary",
            chain_hangs,
            "NNCG and PGS are solvers of contacts; they solve joints by sweeps, and a chain under tension stretches without end. Joints \
             are for Soft Step, which solves them directly: the depth is met at every step. At 0.1 s the pull of one chain swings, and \
             its mean over a second is off.",
        )
    },
    case(
        "Mortar: a cantilever",
        cantilever_breaks,
        "Bonds under NNCG and PGS are weak: they are solved by sweeps.",
    ),
];
