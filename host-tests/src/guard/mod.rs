//! Guards of the diagnosis: twins that are changed, and rigs that have something on top, on recordings of `quadcal simulate`.
//!
//! What a difference between two twins shows at all is said by [`sight`], from simulations without noise.

pub mod bench;
pub mod change;
pub mod judge;
pub mod plant;
pub mod sight;
pub mod tree;
