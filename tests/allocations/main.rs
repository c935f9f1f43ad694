//! How much memory steps take, as their allocator counts it. The allocator counts for all threads, so these tests run one after the
//! other, inside one test function.

mod leaks;
mod steps;

use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static MEMORY: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

#[test]
fn steady_steps_allocate_nothing_and_islands_leave_nothing_behind() {
    steps::a_steady_step_allocates_nothing();
    leaks::islands_that_cease_to_rest_leave_nothing_behind();
}
