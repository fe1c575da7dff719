//! Where a recording and its twin differ, and why.

pub mod diagnosis;
pub mod kalman;
pub mod model;
pub mod residual;
pub mod run;
pub mod scan;
pub mod search;
pub mod shown;
pub mod term;
pub mod track;
