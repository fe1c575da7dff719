//! A twin's text with another twin's values in it: comments, order and layout stay, so that a comparison of both texts shows what is
//! new and nothing else.

use toml_edit::{
    Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, TomlError, Value,
};

use super::error::{self, Place};
use super::{Twin, TwinError};

/// What a key holds, without its layout.
#[derive(Clone, Debug)]
enum Tree {
    Leaf(Value),
    List(Vec<Tree>),
    Map(Vec<(String, Tree)>),
}

impl PartialEq for Tree {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            // Both come from the same writer, so that equal values have equal texts.
            (Self::Leaf(a), Self::Leaf(b)) => a.to_string().trim() == b.to_string().trim(),
            (Self::List(a), Self::List(b)) => a == b,
            (Self::Map(a), Self::Map(b)) => a == b,
            _ => false,
        }
    }
}

type Map = [(String, Tree)];

/// The text of the twin `old` with only the values changed in which `new` differs. New sections come at the end, in the order in which
/// [`Twin::to_toml`] has them, new keys at the end of their section; what `new` does not have is taken out with its comments.
///
/// # Errors
/// As [`Twin::to_toml`]; [`TwinError::Syntax`] for an old text that is no TOML.
pub fn edited(old_text: &str, old: &Twin, new: &Twin) -> Result<String, TwinError> {
    let written = new.to_toml()?;
    let mut text: DocumentMut = parsed(old_text, old)?;
    let before = tree_of(parsed(&toml::to_string(old)?, old)?.as_table());
    let after = tree_of(parsed(&written, new)?.as_table());
    let sections: Vec<String> = text.iter().map(|(key, _)| key.to_owned()).collect();
    apply(text.as_table_mut(), false, &before, &after);
    for (key, item) in text.as_table_mut().iter_mut() {
        if !sections.iter().any(|section| key == section.as_str()) {
            put_last(item);
        }
    }
    let text = text.to_string();
    // A layout that can't be kept is given up, and never a value.
    let read: Option<Twin> = toml::from_str(&text).ok();
    let kept = read.and_then(|twin| toml::to_string(&twin).ok());
    Ok(if kept.as_ref() == Some(&written) {
        text
    } else {
        written
    })
}

fn parsed(text: &str, twin: &Twin) -> Result<DocumentMut, TwinError> {
    text.parse().map_err(|error: TomlError| TwinError::Syntax {
        place: Place {
            name: twin.name.clone(),
            position: error
                .span()
                .map(|span| error::line_column(text, span.start)),
        },
        key: String::new(),
        message: error.message().replace('\n', ", "),
    })
}

fn tree_of(table: &dyn TableLike) -> Vec<(String, Tree)> {
    let entry = |(key, item): (&str, &Item)| (key.to_owned(), tree_of_item(item));
    table.iter().map(entry).collect()
}

fn tree_of_item(item: &Item) -> Tree {
    match item {
        Item::Table(table) => Tree::Map(tree_of(table)),
        Item::ArrayOfTables(tables) => Tree::List(
            tables
                .iter()
                .map(|table| Tree::Map(tree_of(table)))
                .collect(),
        ),
        Item::Value(value) => tree_of_value(value),
        Item::None => Tree::List(Vec::new()),
    }
}

fn tree_of_value(value: &Value) -> Tree {
    match value {
        Value::InlineTable(table) => Tree::Map(tree_of(table)),
        Value::Array(values) => Tree::List(values.iter().map(tree_of_value).collect()),
        _ => {
            let mut value = value.clone();
            value.decor_mut().clear();
            Tree::Leaf(value)
        }
    }
}

fn get<'a>(map: &'a Map, key: &str) -> Option<&'a Tree> {
    map.iter()
        .find(|(name, _)| name == key)
        .map(|(_, tree)| tree)
}

/// Changes a table from `old` to `new`; `inline` if it has no room for sections.
fn apply(table: &mut dyn TableLike, inline: bool, old: &Map, new: &Map) {
    for (key, _) in old {
        if get(new, key).is_none() {
            table.remove(key);
        }
    }
    for (key, tree) in new {
        let before = get(old, key);
        if before == Some(tree) {
            continue;
        }
        match table.get_mut(key) {
            Some(item) => change(item, before, tree),
            None if inline => _ = table.insert(key, Item::Value(value_of(tree))),
            None => _ = table.insert(key, item_of(tree)),
        }
    }
}

fn change(item: &mut Item, old: Option<&Tree>, new: &Tree) {
    match (item, new) {
        (Item::Table(table), Tree::Map(new)) => {
            let inline = table.is_dotted();
            apply(table, inline, map_of(old), new);
        }
        (Item::ArrayOfTables(tables), Tree::List(new)) => change_tables(tables, list_of(old), new),
        (Item::Value(value), new) => change_value(value, old, new),
        (item, new) => *item = item_of(new),
    }
}

fn change_value(value: &mut Value, old: Option<&Tree>, new: &Tree) {
    match (&mut *value, new) {
        (Value::InlineTable(table), Tree::Map(new)) => apply(table, true, map_of(old), new),
        (Value::Array(values), Tree::List(new)) => change_values(values, list_of(old), new),
        (_, new) => {
            let decor = value.decor().clone();
            *value = value_of(new);
            *value.decor_mut() = decor;
        }
    }
}

fn map_of(tree: Option<&Tree>) -> &Map {
    match tree {
        Some(Tree::Map(map)) => map,
        _ => &[],
    }
}

fn list_of(tree: Option<&Tree>) -> &[Tree] {
    match tree {
        Some(Tree::List(list)) => list,
        _ => &[],
    }
}

/// What becomes of the entries of a list, in order.
enum Step<'a> {
    Keep,
    Change(&'a Tree, &'a Tree),
    Remove,
    Insert(&'a Tree),
}

/// Most pairs of entries that are compared; of longer lists only start and end are.
const PAIRS_MAX: usize = 1 << 20;

/// The way from one list to another. Entries that both have stay, those between them are changed in pairs.
fn steps<'a>(old: &'a [Tree], new: &'a [Tree]) -> Vec<Step<'a>> {
    let pairs = old.iter().zip(new);
    let start = pairs.take_while(|(a, b)| a == b).count();
    let rest = old[start..].iter().rev().zip(new[start..].iter().rev());
    let end = rest.take_while(|(a, b)| a == b).count();
    let (old, new) = (&old[start..old.len() - end], &new[start..new.len() - end]);
    let keep = |count| std::iter::repeat_with(|| Step::Keep).take(count);
    let mut steps: Vec<Step<'a>> = keep(start).collect();
    let (mut i, mut j) = (0, 0);
    for (kept_i, kept_j) in common(old, new) {
        between(&mut steps, &old[i..kept_i], &new[j..kept_j]);
        steps.push(Step::Keep);
        (i, j) = (kept_i + 1, kept_j + 1);
    }
    between(&mut steps, &old[i..], &new[j..]);
    steps.extend(keep(end));
    steps
}

fn between<'a>(steps: &mut Vec<Step<'a>>, old: &'a [Tree], new: &'a [Tree]) {
    let pairs = old.iter().zip(new);
    steps.extend(pairs.map(|(old, new)| Step::Change(old, new)));
    steps.extend(old.iter().skip(new.len()).map(|_| Step::Remove));
    steps.extend(new.iter().skip(old.len()).map(Step::Insert));
}

/// Places of the longest common subsequence.
fn common(old: &[Tree], new: &[Tree]) -> Vec<(usize, usize)> {
    let (rows, columns) = (old.len(), new.len());
    if rows.saturating_mul(columns) > PAIRS_MAX {
        return Vec::new();
    }
    // Longest length from a pair of places on.
    let mut longest = vec![vec![0_u32; columns + 1]; rows + 1];
    for i in (0..rows).rev() {
        for j in (0..columns).rev() {
            longest[i][j] = if old[i] == new[j] {
                longest[i + 1][j + 1] + 1
            } else {
                longest[i + 1][j].max(longest[i][j + 1])
            };
        }
    }
    let (mut i, mut j, mut places) = (0, 0, Vec::new());
    while i < rows && j < columns {
        if old[i] == new[j] {
            places.push((i, j));
            (i, j) = (i + 1, j + 1);
        } else if longest[i + 1][j] >= longest[i][j + 1] {
            i += 1;
        } else {
            j += 1;
        }
    }
    places
}

fn change_tables(tables: &mut ArrayOfTables, old: &[Tree], new: &[Tree]) {
    let mut at = 0;
    for step in steps(old, new) {
        match step {
            Step::Keep => {}
            Step::Change(old, new) => {
                if let Some(table) = tables.get_mut(at) {
                    apply(table, false, map_of(Some(old)), map_of(Some(new)));
                }
            }
            Step::Remove => {
                if at < tables.len() {
                    tables.remove(at);
                }
                continue;
            }
            Step::Insert(new) => {
                tables.insert(at.min(tables.len()), table_of(map_of(Some(new))));
            }
        }
        at += 1;
    }
}

fn change_values(values: &mut Array, old: &[Tree], new: &[Tree]) {
    let mut at = 0;
    for step in steps(old, new) {
        match step {
            Step::Keep => {}
            Step::Change(old, new) => {
                if let Some(value) = values.get_mut(at) {
                    change_value(value, Some(old), new);
                }
            }
            Step::Remove => {
                if at < values.len() {
                    values.remove(at);
                }
                continue;
            }
            Step::Insert(new) => values.insert(at.min(values.len()), value_of(new)),
        }
        at += 1;
    }
}

/// A tree as a section, or as a key of one.
fn item_of(tree: &Tree) -> Item {
    match tree {
        Tree::Map(map) => Item::Table(table_of(map)),
        Tree::List(list) if list.iter().all(|tree| matches!(tree, Tree::Map(_))) => {
            Item::ArrayOfTables(
                list.iter()
                    .map(|tree| table_of(map_of(Some(tree))))
                    .collect(),
            )
        }
        tree => Item::Value(value_of(tree)),
    }
}

fn table_of(map: &Map) -> Table {
    let mut table: Table = map.iter().map(|(key, tree)| (key, item_of(tree))).collect();
    // Without keys of its own it needs no line of its own.
    table.set_implicit(map.iter().all(|(_, tree)| matches!(tree, Tree::Map(_))));
    table.decor_mut().set_prefix("\n");
    table
}

fn value_of(tree: &Tree) -> Value {
    match tree {
        Tree::Leaf(value) => value.clone(),
        Tree::List(list) => Value::Array(list.iter().map(value_of).collect()),
        Tree::Map(map) => {
            let entries = map.iter().map(|(key, tree)| (key, value_of(tree)));
            Value::InlineTable(entries.collect::<InlineTable>())
        }
    }
}

/// Puts a new section behind all others.
fn put_last(item: &mut Item) {
    let tables: &mut dyn Iterator<Item = &mut Table> = match item {
        Item::Table(table) => &mut std::iter::once(table),
        Item::ArrayOfTables(tables) => &mut tables.iter_mut(),
        Item::Value(_) | Item::None => return,
    };
    for table in tables {
        table.set_position(Some(isize::MAX));
        for (_, item) in table.iter_mut() {
            put_last(item);
        }
    }
}
