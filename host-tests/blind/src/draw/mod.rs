//! Drawing of cases: rigs, effects, kinds.

mod case;
mod cells;
mod effects;
mod family;
mod hidden;
mod kind;
mod limits;
mod outside;
mod record;
mod rigs;
mod settle;
#[cfg(test)]
mod tests;

pub use case::{Case, again, case};
pub use effects::CATALOGUE;
pub use family::Family;
pub use kind::{Kind, plan};
pub use rigs::{Shape, rigs};
