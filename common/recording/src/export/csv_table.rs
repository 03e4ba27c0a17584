//! A table as CSV.

use std::io::Write;

use super::{ExportError, TableWriter, columns};
use crate::read_table::{ReadTable, Row};

pub(super) struct CsvTable<W: Write>(csv::Writer<W>);

impl<W: Write> CsvTable<W> {
    pub(super) fn new(to: W, table: &ReadTable) -> Result<Self, ExportError> {
        // The columns are known by name only at run time; automatic headers would come from field names of a type.
        let mut csv = csv::WriterBuilder::new().has_headers(false).from_writer(to);
        csv.write_record(columns(table))?;
        Ok(Self(csv))
    }
}

impl<W: Write> TableWriter for CsvTable<W> {
    fn row(&mut self, row: &Row) -> Result<(), ExportError> {
        Ok(self.0.serialize((row.at_ns, row.woke_ns, &row.values))?)
    }

    fn finish(mut self: Box<Self>) -> Result<(), ExportError> {
        Ok(self.0.flush()?)
    }
}
