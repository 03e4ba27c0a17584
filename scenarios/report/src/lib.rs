//! Results of experiments, for people: tables on a terminal, pages that open without a network, SVG and PDF for papers.
//!
//! From the top down:
//!
//! * [`reported`] runs a scenario and writes its report, [`sweep`] does so over a grid;
//! * [`run`] is the report of a run: figures and their page;
//! * [`table`] has the results of a run for a terminal;
//! * [`inspect`] has the parts that commands share which look into a file: answers, tables, numbers and charts;
//! * [`figure`] is the one model of what is drawn; [`page`] draws it in a browser, [`print`](mod@print) as SVG and PDF;
//! * [`plotting`] has what all plots share, those of nodes that run among them: colours, numbers, axes.
//!
//! The crate depends on the lab, and on neither Zenoh nor a server.

pub mod figure;
mod html;
pub mod inspect;
pub mod page;
pub mod plotting;
pub mod print;
pub mod reported;
pub mod run;
pub mod sweep;
pub mod table;
