//! Cam plates that the slave axes of a program share: [`Tables`].

use core::ffi::c_char;
use std::path::Path;

use coaxle_cam::Tables;
use coaxle_files::cam::CamFile;
use coaxle_plate::{Course, MotionFunction, Plate};

use crate::command::coaxle_motion_point;
use crate::failure::{COAXLE_TEXT, Failure};
use crate::handle::{HandleHead, call, free, handle, make};
use crate::memory::{readable_array, text, writable};

/// A store of cam plates (`MC_CamTableSelect`), for any number of slave axes in one thread.
#[repr(C)]
#[derive(Debug)]
pub struct coaxle_tables {
    head: HandleHead,
    pub(crate) tables: Tables,
}

handle!(coaxle_tables, b"camtable");

/// Makes a store for up to `capacity` plates, 1 to 255.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_tables_new(capacity: u32, out: *mut *mut coaxle_tables) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        make(out, || match capacity {
            1..=255 => Ok(coaxle_tables {
                head: HandleHead::new::<coaxle_tables>(),
                tables: Tables::new(capacity as usize),
            }),
            _ => Err(Failure::range("capacity", capacity, "1 to 255")),
        })
    }
}

/// Frees a store, which no axis uses any more; `NULL` is left alone.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_tables_free(tables: *mut coaxle_tables) {
    // SAFETY: as for this function.
    unsafe { free(tables) }
}

/// Adds a plate of points, in the order of their indices from 1. `is_cyclic` is other than 0 for one that repeats. Allocates.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_tables_add_points(
    tables: *mut coaxle_tables,
    table: u32,
    is_cyclic: u32,
    points: *const coaxle_motion_point,
    number: usize,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(tables, |store| {
            let points = readable_array(points, number, "points")?;
            let points = points.iter().map(coaxle_motion_point::checked);
            let points = points.collect::<Result<Vec<_>, _>>()?;
            let course = match is_cyclic {
                0 => Course::Linear,
                _ => Course::Cyclic,
            };
            let function =
                MotionFunction::new(points).map_err(|wrong| Failure::of_nc(wrong.code(), wrong))?;
            let plate = Plate::from_function(function, course);
            (store.tables.insert(table, plate)).map_err(|wrong| Failure::of_nc(wrong.code(), wrong))
        })
    }
}

/// Adds the plate of a cam file's text. `name` stands for the file in errors; files that it names are read from the folder of `name`.
/// Allocates.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_tables_add_file(
    tables: *mut coaxle_tables,
    table: u32,
    name: *const c_char,
    contents: *const c_char,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(tables, |store| {
            let (name, contents) = (text(name, "name")?, text(contents, "contents")?);
            let plate = CamFile::parse(Path::new(name), contents).and_then(|file| file.plate());
            let plate = plate.map_err(|wrong| match wrong.code() {
                Some(code) => Failure::of_nc(code, wrong),
                None => Failure::new(COAXLE_TEXT, wrong),
            })?;
            (store.tables.insert(table, plate)).map_err(|wrong| Failure::of_nc(wrong.code(), wrong))
        })
    }
}

/// Removes a plate that no axis is on. Frees memory.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_tables_remove(tables: *mut coaxle_tables, table: u32) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(tables, |store| {
            (store.tables.remove(table).map(drop))
                .map_err(|wrong| Failure::of_nc(wrong.code(), wrong))
        })
    }
}

/// Passes out the slave of a plate at the position `master`: position (u), velocity (u/x), acceleration (u/x²) and jerk (u/x³) in
/// `motion`, which has four places.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_tables_at(
    tables: *mut coaxle_tables,
    table: u32,
    master: f64,
    motion: *mut f64,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(tables, |store| {
            let out = writable(motion.cast::<[f64; 4]>(), "motion")?;
            let plate =
                (store.tables.plate(table)).map_err(|wrong| Failure::of_nc(wrong.code(), wrong))?;
            let at = plate.at(master);
            *out = [at.position, at.velocity, at.acceleration, at.jerk];
            Ok(())
        })
    }
}
