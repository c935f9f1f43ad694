use super::*;
use glam::Vec3;
use std::marker::PhantomData;

/// Checks the arithmetic of each lane against plain numbers.
struct Arithmetic<L>(PhantomData<L>);

fn of<L: F32xN>(number: impl Fn(usize) -> f32) -> L {
    let mut lanes = L::default();
    for lane in 0..L::LANES {
        lanes[lane] = number(lane);
    }
    lanes
}

impl<L: F32xN> Kernel for Arithmetic<L> {
    type Output = ();

    fn run(self) {
        let x = |lane: usize| 1.7 * lane as f32 - 4.0;
        let y = |lane: usize| 0.3 + 0.7 * lane as f32;
        let z = |lane: usize| 5.0 - 2.1 * lane as f32;
        let (a, b, c) = (of::<L>(x), of::<L>(y), of::<L>(z));
        let check = |found: L, wanted: &dyn Fn(usize) -> f32| {
            for lane in 0..L::LANES {
                let (found, wanted) = (found[lane], wanted(lane));
                let off = (found - wanted).abs();
                assert!(off <= 1e-6 * (1.0 + wanted.abs()), "{found}, not {wanted}");
            }
        };
        check(a + b, &|i| x(i) + y(i));
        check(a - b, &|i| x(i) - y(i));
        check(a * b, &|i| x(i) * y(i));
        check(-a, &|i| -x(i));
        check(a.max(b), &|i| x(i).max(y(i)));
        check(a.min(b), &|i| x(i).min(y(i)));
        check(b.sqrt(), &|i| y(i).sqrt());
        check(a.inverse(), &|i| if x(i) > 0.0 { 1.0 / x(i) } else { 0.0 });
        check(L::ZERO.inverse(), &|_| 0.0);
        check(a.mul_add(b, c), &|i| x(i) * y(i) + z(i));
        check(a.mul_sub(b, c), &|i| x(i) * y(i) - z(i));
        check(a.neg_mul_add(b, c), &|i| z(i) - x(i) * y(i));
        check(a.select_above(c, a, b), &|i| {
            if x(i) > z(i) { x(i) } else { y(i) }
        });
        check(L::splat(2.5), &|_| 2.5);
        let mut sum = a;
        sum += b;
        sum -= c;
        check(sum, &|i| x(i) + y(i) - z(i));
        assert_eq!(L::ONE.sum(), L::LANES as f32);
        let last = L::LANES - 1;
        assert!(a.any_above(L::splat(x(last) - 0.1)) && !a.any_above(L::splat(x(last))));
    }
}

/// Gathers states, and scatters them in another order.
struct Exchange<'a, L>(&'a mut [State], PhantomData<L>);

impl<L: F32xN> Kernel for Exchange<'_, L> {
    type Output = SpatialVec<L>;

    fn run(self) -> SpatialVec<L> {
        let mut from = L::bodies(0);
        let mut to = L::bodies(0);
        for lane in 0..L::LANES {
            L::set_body(&mut from, lane, lane as u32 + 1);
            L::set_body(&mut to, lane, (L::LANES - lane) as u32);
        }
        let states = cells(self.0);
        let motion = L::gather(states, &from);
        L::scatter(states, &to, &motion);
        motion
    }
}

fn state(body: usize) -> State {
    let v = Vec3::new(1.0, 2.0, 3.0) + 10.0 * body as f32;
    [v.extend(0.0), (-v).extend(0.0)]
}

fn check<L: F32xN>() {
    L::run(Arithmetic::<L>(PhantomData));
    let mut states: Vec<State> = (0..=L::LANES).map(state).collect();
    let motion = L::run(Exchange::<L>(&mut states, PhantomData));
    assert_eq!(states[0], state(0));
    for lane in 0..L::LANES {
        let [linear, angular] = state(lane + 1);
        assert_eq!(motion.linear.get(lane).extend(0.0), linear);
        assert_eq!(motion.angular.get(lane).extend(0.0), angular);
        assert_eq!(states[L::LANES - lane], state(lane + 1));
    }
}

#[test]
fn four_lanes_do_what_numbers_do() {
    check::<F32x4>();
}

#[cfg(target_arch = "x86_64")]
#[test]
fn eight_lanes_do_what_numbers_do() {
    if F32x8::is_available() {
        check::<F32x8>();
        check::<F32x8AsFour>();
    }
}

/// The last body does not exist.
fn reach_too_far<L: F32xN>() {
    let mut states = vec![State::default(); L::LANES];
    L::run(Exchange::<L>(&mut states, PhantomData));
}

#[test]
#[should_panic]
fn four_lanes_keep_to_their_bodies() {
    reach_too_far::<F32x4>();
}

#[cfg(target_arch = "x86_64")]
#[test]
#[should_panic]
fn eight_lanes_keep_to_their_bodies() {
    if F32x8::is_available() {
        reach_too_far::<F32x8>();
    }
    panic!("there is nothing to test");
}
