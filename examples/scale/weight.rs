//! What a brick weighs: the memory of walls that are awake, and of the same walls asleep.

use super::{Arguments, CROWD, MEMORY, Site};
use bevy_ecs::prelude::*;
use bevy_ecs::storage::{Table, TableId};
use drystone::prelude::Sleeping;
use drystone_lab::memory;
use stats_alloc::Region;
use std::cmp::Reverse;
use std::error::Error;
use std::fmt::Write;

/// Steps after which all walls must be asleep.
const LIMIT: usize = 600;

/// Number of ECS tables that are listed.
const TABLES: usize = 5;

/// Bytes of the change ticks of a component.
const TICKS: usize = 8;

/// Memory at one time, per brick.
struct Weight {
    what: &'static str,
    resident: f64,
    allocated: f64,
}

/// Measures walls that stand awake for ten steps, and then fall asleep.
pub fn measure(arguments: &Arguments) -> Result<String, Box<dyn Error>> {
    let (region, before) = (Region::new(MEMORY), 1024.0 * memory::resident()?);
    let mut site = Site::new(arguments.threads.unwrap_or(1), true)?;
    let count = arguments.bricks / (CROWD[0] * CROWD[1]);
    let mut bricks = 0;
    for wall in 0..count {
        bricks += site.wall(CROWD, 3.0 * wall as f32, false).len();
    }
    let weigh = |what| -> Result<Weight, Box<dyn Error>> {
        let change = region.change();
        let allocated = change.bytes_allocated as f64 - change.bytes_deallocated as f64;
        Ok(Weight {
            what,
            resident: (1024.0 * memory::resident()? - before) / bricks as f64,
            allocated: allocated / bricks as f64,
        })
    };
    let mut weights = vec![weigh("spawned")?];
    site.steps(10);
    weights.push(weigh("awake")?);
    let of_tables = tables(site.app.world(), bricks)?;
    let mut steps = 0;
    while is_awake(site.app.world_mut()) {
        site.step();
        steps += 1;
        if steps > LIMIT {
            return Err("the walls do not fall asleep".into());
        }
    }
    site.steps(5);
    weights.push(weigh("asleep")?);
    let mut text = format!(
        "| {bricks} bricks in {count} walls | resident, B a brick | allocated, B a brick |\n|---|---|---|\n"
    );
    for weight in weights {
        let Weight {
            what,
            resident,
            allocated,
        } = weight;
        writeln!(text, "| {what} | {resident:.0} | {allocated:.0} |")?;
    }
    writeln!(text, "\nTables while awake:\n{of_tables}")?;
    writeln!(
        text,
        "Tables while asleep:\n{}",
        tables(site.app.world(), bricks)?
    )?;
    Ok(text)
}

fn is_awake(world: &mut World) -> bool {
    let mut bodies = world.query::<&Sleeping>();
    let asleep = bodies.iter(world).filter(|sleeping| sleeping.asleep);
    asleep.count() < bodies.iter(world).count() - 1
}

/// The largest tables of the ECS.
fn tables(world: &World, bricks: usize) -> Result<String, Box<dyn Error>> {
    let mut found: Vec<(TableId, &Table, usize)> = Vec::new();
    for archetype in world.archetypes().iter() {
        let id = archetype.table_id();
        let columns = archetype.table_components();
        let sizes = columns.filter_map(|id| Some(world.components().get_info(id)?.layout().size()));
        let row = size_of::<Entity>() + sizes.map(|size| size + TICKS).sum::<usize>();
        if let Some(table) = world.storages().tables.get(id)
            && found.iter().all(|&(known, ..)| known != id)
        {
            found.push((id, table, row));
        }
    }
    found.sort_by_key(|(_, table, row)| Reverse(table.capacity() * row));
    let mut text = String::from(
        "| rows a brick | room for | columns | B a row | B a brick, for all rows that there is room for |\n|---|---|---|---|---|\n",
    );
    for (_, table, row) in found.into_iter().take(TABLES) {
        let share = |count: usize| count as f64 / bricks as f64;
        writeln!(
            text,
            "| {:.2} | {:.2} | {} | {row} | {:.0} |",
            share(table.entity_count() as usize),
            share(table.capacity()),
            table.component_count(),
            share(table.capacity() * row)
        )?;
    }
    Ok(text)
}
