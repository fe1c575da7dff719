//! Whole-behaviour tests of core and tool: shared helpers.
#![forbid(unsafe_code)]
