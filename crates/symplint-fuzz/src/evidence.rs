//! Evidence that no diagnosis would find: that of real ones, with numbers, lists and variants changed.
//!
//! As TOML values, which have infinities and NaN.

use std::sync::OnceLock;

use arbitrary::{Result, Unstructured};
use serde::Deserialize;
use symplint::Evidence;
use toml::Value;

use crate::numbers;
use crate::seeds;
use crate::verdicts::judge_and_write;

/// Lists are not made longer than this.
const MAX_LIST_LENGTH: usize = 512;

/// Changes real evidence as the bytes say, and judges it.
pub fn evidence(data: &[u8]) {
    if let Ok(changed) = changed(&mut Unstructured::new(data))
        && let Ok(evidence) = Evidence::deserialize(changed)
    {
        judge_and_write(evidence);
    }
}

fn changed(u: &mut Unstructured<'_>) -> Result<Value> {
    let known = known();
    let mut value = u.choose(known)?.clone();
    for _ in 0..u.int_in_range(1..=12)? {
        if u.is_empty() {
            break;
        }
        change(&mut value, u)?;
    }
    Ok(value)
}

fn known() -> &'static [Value] {
    static KNOWN: OnceLock<Vec<Value>> = OnceLock::new();
    KNOWN.get_or_init(|| {
        let as_toml = |evidence| Value::try_from(evidence).expect("evidence is a tree of values");
        seeds::evidence().iter().map(as_toml).collect()
    })
}

/// Goes down the tree as the bytes say, and changes what it comes to.
fn change(value: &mut Value, u: &mut Unstructured<'_>) -> Result<()> {
    let stops = u.ratio(1, 8)?;
    match value {
        Value::Table(table) if !stops && !table.is_empty() => {
            let index = u.choose_index(table.len())?;
            let (_, child) = table.iter_mut().nth(index).expect("an index of the table");
            change(child, u)
        }
        Value::Array(list) if !stops && !list.is_empty() => {
            let index = u.choose_index(list.len())?;
            change(&mut list[index], u)
        }
        Value::Table(table) => change_table(table, u),
        Value::Array(list) => change_list(list, u),
        Value::Float(number) => {
            *number = match u.ratio(1, 4)? {
                true => *number * numbers::ordinary(u)?,
                false => numbers::any(u)?,
            };
            Ok(())
        }
        Value::Integer(number) => {
            *number = match u.int_in_range(0..=3)? {
                0 => 0,
                1 => i64::MAX,
                2 => u.int_in_range(0..=40)?,
                _ => number.saturating_add(u.int_in_range(-3..=3)?).max(0),
            };
            Ok(())
        }
        Value::Boolean(flag) => {
            *flag = !*flag;
            Ok(())
        }
        Value::String(text) => {
            *text = (*u.choose(&VARIANTS)?).to_owned();
            Ok(())
        }
        Value::Datetime(_) => Ok(()),
    }
}

/// Leaves out a value, or takes one of other evidence.
fn change_table(table: &mut toml::Table, u: &mut Unstructured<'_>) -> Result<()> {
    let donor = u.choose(known())?.as_table().expect("evidence is a table");
    if u.arbitrary()? && !table.is_empty() {
        let index = u.choose_index(table.len())?;
        let key = table.keys().nth(index).cloned();
        table.remove(&key.expect("an index of the table"));
    } else {
        let index = u.choose_index(donor.len())?;
        let (key, value) = donor.iter().nth(index).expect("an index of the table");
        table.insert(key.clone(), value.clone());
    }
    Ok(())
}

/// Empties a list, shortens, repeats, reverses it, or changes the order.
fn change_list(list: &mut Vec<Value>, u: &mut Unstructured<'_>) -> Result<()> {
    if list.is_empty() {
        return Ok(());
    }
    let place = u.choose_index(list.len())?;
    match u.int_in_range(0..=4)? {
        0 => list.clear(),
        1 => list.truncate(place),
        2 => list.reverse(),
        3 => list.rotate_left(place),
        _ => {
            let more: Vec<Value> = list.clone();
            while list.len() + more.len() <= MAX_LIST_LENGTH {
                list.extend(more.iter().cloned());
                if u.ratio(1, 4)? {
                    break;
                }
            }
        }
    }
    Ok(())
}

/// Names of variants in reports, and no name.
const VARIANTS: [&str; 24] = [
    "map",
    "samples",
    "given",
    "random",
    "extended",
    "group",
    "winding",
    "image",
    "auto",
    "pseudospectral",
    "finite-difference",
    "piecewise",
    "streaming",
    "jump-detecting",
    "step-sizes",
    "random-loops",
    "sample-sweep",
    "jacobian-budget",
    "jacobian-memory",
    "localisation-budget",
    "manifold-budget",
    "contraction-budget",
    "long-time-budget",
    "",
];
