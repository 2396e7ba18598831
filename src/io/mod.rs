//! Files in and out: coefficients, images, tables, and the rules by which anything is written.

pub mod coefficients;
pub mod images;
pub mod output;
pub mod tables;
