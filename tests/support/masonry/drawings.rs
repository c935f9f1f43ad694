//! Drawings of the structures that are tested and built.

use crate::masonry::blocks::{Block, Masonry};
use glam::{DVec2, dvec2};
use std::f64::consts::PI;

/// The mean radius of arches, m.
pub const RADIUS: f64 = 3.0;

/// A floor whose top is y = 0.
fn floor() -> Block {
    Block::rectangle(dvec2(-8.0, -1.0), dvec2(16.0, 1.0)).fixed()
}

/// So many unit cubes on a floor.
pub fn stack(n: usize, friction: f64) -> Masonry {
    let cube = |i| Block::rectangle(dvec2(-0.5, i as f64), DVec2::ONE);
    let mut blocks = vec![floor()];
    blocks.extend((0..n).map(cube));
    Masonry { blocks, friction }
}

/// Running bond of so many bricks 1 × 0.5 × 0.5 m to a course, half bricks at the ends of every second, on a floor; `gap`: by how much
/// bricks are shorter, so that neighbours don't touch, m.
pub fn wall(width: usize, courses: usize, gap: f64, friction: f64) -> Masonry {
    let height = 0.5;
    let brick = |from: f64, to: f64, course: usize| {
        let left = from + 0.5 * (gap - width as f64);
        let corner = dvec2(left, course as f64 * height);
        let mut brick = Block::rectangle(corner, dvec2(to - from - gap, height));
        brick.depth = 0.5;
        brick
    };
    let mut blocks = vec![floor()];
    for course in 0..courses {
        let first = 0.5 * (course % 2) as f64;
        let joints = (0..=width).map(|i| (i as f64 - first).max(0.0));
        let mut ends: Vec<f64> = joints.collect();
        if first > 0.0 {
            ends.push(width as f64);
        }
        blocks.extend(ends.windows(2).map(|ends| brick(ends[0], ends[1], course)));
    }
    Masonry { blocks, friction }
}

/// A block with sloping sides, 0.5 m high, on a floor.
pub fn frustum(friction: f64) -> Masonry {
    let outline = [(-1.0, 0.0), (1.0, 0.0), (0.6, 0.5), (-0.4, 0.5)].map(DVec2::from);
    Masonry {
        blocks: vec![floor(), Block::new(&outline)],
        friction,
    }
}

/// A wedge from one height to another with its narrow end down: its sides lean out by `half`, °, and would be `foot` from the middle
/// at y = 0.
fn wedge(half: f64, foot: f64, [low, high]: [f64; 2]) -> Block {
    let off = |y: f64| foot + y * half.to_radians().tan();
    let corners = [
        (-off(low), low),
        (off(low), low),
        (off(high), high),
        (-off(high), high),
    ];
    Block::new(&corners.map(DVec2::from))
}

/// The block of 1 m height to the left (−1) or right (1) of that wedge, with its foot on y = 0 and `wide` m wide there.
fn beside(side: f64, half: f64, foot: f64, wide: f64) -> Block {
    let top = foot + half.to_radians().tan();
    let outer = foot + wide;
    let mut corners = [
        (foot, 0.0),
        (outer, 0.0),
        (outer.max(top + 0.5), 1.0),
        (top, 1.0),
    ]
    .map(|(x, y)| dvec2(side * x, y));
    if side < 0.0 {
        corners.reverse();
    }
    Block::new(&corners)
}

/// A wedge between two fixed blocks, which have sides like its own.
pub fn groove(half: f64, friction: f64) -> Masonry {
    let support = |side| beside(side, half, 0.5, 1.0).fixed();
    Masonry {
        blocks: vec![support(-1.0), support(1.0), wedge(half, 0.5, [0.0, 1.0])],
        friction,
    }
}

/// Two blocks on a floor, and a wedge that parts them.
pub fn splitter(half: f64, friction: f64) -> Masonry {
    let part = |side| beside(side, half, 0.3, 2.0);
    Masonry {
        blocks: vec![
            floor(),
            part(-1.0),
            part(1.0),
            wedge(half, 0.3, [0.25, 1.0]),
        ],
        friction,
    }
}

/// A half circle of so many voussoirs on a floor; `share`: its thickness as a share of its mean radius.
pub fn arch(n: usize, share: f64, friction: f64) -> Masonry {
    let [inner, outer] = [-0.5, 0.5].map(|side| RADIUS * (1.0 + side * share));
    let voussoir = |i: usize| {
        let [from, to] = [i, i + 1].map(|i| DVec2::from_angle(PI * i as f64 / n as f64));
        Block::new(&[inner * from, outer * from, outer * to, inner * to])
    };
    let mut blocks = vec![floor()];
    blocks.extend((0..n).map(voussoir));
    Masonry { blocks, friction }
}

/// How deep below a flat arch its joints meet, m.
const CENTER: f64 = 5.0;
/// Its span below, m.
const SPAN: f64 = 4.0;

/// The tangent of the angle by which a joint of a flat arch of `n` leans, from −x to +x.
pub fn lean(n: usize, joint: usize) -> f64 {
    SPAN / CENTER * (joint as f64 / n as f64 - 0.5)
}

/// A flat arch 1 m high of so many voussoirs between two fixed abutments, and a block on one of them; that is the last.
pub fn flat_arch(n: usize, friction: f64, loaded: Option<usize>) -> Masonry {
    let at = |joint: usize, y: f64| dvec2(lean(n, joint) * (CENTER + y), y);
    let voussoir = |i: usize| Block::new(&[at(i, 0.0), at(i + 1, 0.0), at(i + 1, 1.0), at(i, 1.0)]);
    let abutment = |joint: usize, way: f64| {
        let away = dvec2(way, 0.0);
        let [low, high] = [at(joint, 0.0), at(joint, 1.0)];
        let mut corners = [low, low + 1.5 * away, high + away, high];
        if way < 0.0 {
            corners.reverse();
        }
        Block::new(&corners).fixed()
    };
    let mut blocks = vec![abutment(0, -1.0), abutment(n, 1.0)];
    blocks.extend((0..n).map(voussoir));
    if let Some(i) = loaded {
        let middle = 0.5 * (at(i, 1.0) + at(i + 1, 1.0));
        blocks.push(Block::rectangle(middle - dvec2(0.3, 0.0), dvec2(0.6, 0.5)));
    }
    Masonry { blocks, friction }
}
