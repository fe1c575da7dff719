//! Where a recording and its twin differ, and why.

pub mod kalman;
pub mod model;
pub mod residual;
pub mod scan;
pub mod search;
pub mod term;
pub mod track;
