//! Tests of the public face of `haptic-tissue`, in one binary.

mod closed_forms;
mod export;
mod records;
mod rendering;
mod ting;
mod tissue_files;
