//! Twins as trees of keys: what a change of one key is made on, whatever the key means.

use anyhow::{Context, Result};
use quadcal_host::twin::Twin;
use toml::{Table, Value};

/// One step of a key's path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Into a section.
    Key(String),
    /// To an element of a list of sections.
    At(usize),
}

/// A path, as in `gear_mesh[0].torque_n_m`.
#[must_use]
pub fn shown(path: &[Step]) -> String {
    let mut text = String::new();
    for step in path {
        match step {
            Step::Key(key) if text.is_empty() => text.push_str(key),
            Step::Key(key) => text.extend([".", key]),
            Step::At(at) => text.push_str(&format!("[{at}]")),
        }
    }
    text
}

/// The path of dotted keys.
#[must_use]
pub fn path(dotted: &str) -> Vec<Step> {
    let keys = dotted.split('.').map(str::to_owned);
    keys.map(Step::Key).collect()
}

/// The value at a path.
#[must_use]
pub fn get<'a>(tree: &'a Table, path: &[Step]) -> Option<&'a Value> {
    let (Step::Key(first), rest) = path.split_first()? else {
        return None;
    };
    rest.iter()
        .try_fold(tree.get(first)?, |value, step| match step {
            Step::Key(key) => value.get(key),
            Step::At(at) => value.get(at),
        })
}

/// A number at dotted keys.
#[must_use]
pub fn number(tree: &Table, dotted: &str) -> Option<f64> {
    as_number(get(tree, &path(dotted))?)
}

/// A value as a number.
#[must_use]
pub fn as_number(value: &Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// Sets a value at dotted keys, with the sections on the way.
pub fn set(tree: &mut Table, dotted: &str, value: impl Into<Value>) {
    let mut here = tree;
    let mut keys = dotted.split('.').peekable();
    while let Some(key) = keys.next() {
        if keys.peek().is_none() {
            here.insert(key.to_owned(), value.into());
            return;
        }
        let next = here
            .entry(key)
            .or_insert_with(|| Value::Table(Table::new()));
        match next {
            Value::Table(section) => here = section,
            _ => return,
        }
    }
}

/// Adds to the number at dotted keys; to 0 where there is none.
pub fn add(tree: &mut Table, dotted: &str, more: f64) {
    let now = number(tree, dotted).unwrap_or(0.0);
    set(tree, dotted, now + more);
}

/// Adds a section to a list of sections.
pub fn push(tree: &mut Table, list: &str, section: Table) {
    let list = tree.entry(list).or_insert_with(|| Value::Array(Vec::new()));
    if let Value::Array(list) = list {
        list.push(Value::Table(section));
    }
}

/// Puts a value in the place of the one at a path.
pub fn replace(tree: &mut Table, path: &[Step], value: Value) {
    if let Some(there) = get_mut(tree, path) {
        *there = value;
    }
}

/// Puts a value at a path whose section is there.
pub fn insert(tree: &mut Table, path: &[Step], value: Value) {
    if let Some((Step::Key(key), section)) = path.split_last()
        && let Some(Value::Table(section)) = get_mut(tree, section)
    {
        section.insert(key.clone(), value);
    }
}

/// Takes out what is at a path; a list that is left empty goes with it.
pub fn remove(tree: &mut Table, path: &[Step]) {
    let Some((last, before)) = path.split_last() else {
        return;
    };
    match last {
        Step::Key(key) if before.is_empty() => {
            tree.remove(key);
        }
        Step::Key(key) => {
            if let Some(Value::Table(section)) = get_mut(tree, before) {
                section.remove(key);
            }
        }
        Step::At(at) => {
            let mut empty = false;
            if let Some(Value::Array(list)) = get_mut(tree, before) {
                if *at < list.len() {
                    list.remove(*at);
                }
                empty = list.is_empty();
            }
            if empty {
                remove(tree, before);
            }
        }
    }
}

fn get_mut<'a>(tree: &'a mut Table, path: &[Step]) -> Option<&'a mut Value> {
    let (Step::Key(first), rest) = path.split_first()? else {
        return None;
    };
    rest.iter()
        .try_fold(tree.get_mut(first)?, |value, step| match step {
            Step::Key(key) => value.get_mut(key),
            Step::At(at) => value.get_mut(at),
        })
}

/// The tree of a twin's text.
///
/// # Errors
/// Where it is no TOML.
pub fn parse(text: &str) -> Result<Table> {
    text.parse().context("not TOML")
}

/// The twin of a tree.
///
/// # Errors
/// Where it is no twin.
pub fn twin(tree: &Table) -> Result<Twin> {
    let twin = Twin::parse(&tree.to_string(), "changed twin")?;
    twin.check()?;
    Ok(twin)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a = { b = { c = 2 } }\n[[list]]\nx = 1.5\n[[list]]\nx = 2.5\n";

    #[test]
    fn what_is_removed_and_replaced_is_what_the_path_says() {
        let mut tree = parse(TEXT).unwrap();
        assert_eq!(number(&tree, "a.b.c"), Some(2.0));
        let x = [Step::Key("list".into()), Step::At(1), Step::Key("x".into())];
        assert_eq!(shown(&x), "list[1].x");
        replace(&mut tree, &x, Value::Float(-2.5));
        assert_eq!(get(&tree, &x).and_then(as_number), Some(-2.5));
        remove(&mut tree, &x[..2]);
        assert_eq!(get(&tree, &x), None);
        remove(&mut tree, &[Step::Key("list".into()), Step::At(0)]);
        assert!(!tree.contains_key("list"));
        add(&mut tree, "a.b.c", 0.5);
        add(&mut tree, "new.key", 3.0);
        assert_eq!(number(&tree, "a.b.c"), Some(2.5));
        assert_eq!(number(&tree, "new.key"), Some(3.0));
    }
}
