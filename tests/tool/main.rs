//! The tool as a user meets it: a process for each command, judged by what it says and writes.
//! Every test file that starts the tool is here.

#[path = "../common/mod.rs"]
mod common;

mod cameras;
mod cli;
mod cli_check;
mod cli_compare;
mod cli_convert;
mod cli_detail;
mod cli_exact;
mod cli_falsecolor;
mod cli_fit;
mod cli_illum;
#[cfg(unix)]
mod cli_inputs;
mod cli_many;
mod cli_measures;
mod cli_pictures;
mod cli_render;
mod cli_shapes;
#[cfg(unix)]
mod cli_signals;
mod cli_sweep;
#[cfg(unix)]
mod documents;
mod flags;
mod golden;
mod memory;
mod on_surface;
