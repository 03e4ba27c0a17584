//! What came of experiments, for people: tables on a terminal, pages that open without a network, SVG and PDF for papers.
//!
//! From the top down:
//!
//! * [`reported`] runs a scenario and leaves its report, [`sweep`] does it over a grid;
//! * [`run`] is the report of a run: figures, their page, and [`run::print`], which draws them as SVG and PDF;
//! * [`table`] has the results of a run for a terminal;
//! * [`inspect`] is what commands share that look into a file: answers, tables, numbers and charts;
//! * [`page`] frames a page, with figures of the plotting library; [`plotting`] has what all plots share: colours, axes.
//!
//! It knows the lab, and neither Zenoh nor a server.

pub mod inspect;
pub mod page;
pub mod plotting;
pub mod reported;
pub mod run;
pub mod sweep;
pub mod table;
