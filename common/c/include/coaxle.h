/* Coaxle for C and C++: far clocks, frames, slave axes and whole receivers, called from a loop of one's own.
 * docs/EMBEDDING.md is the manual; this file is made of the sources by cbindgen.
 *
 * Rules of every function:
 *
 * - It returns COAXLE_OK (0), or an error code: below 0 one of this file, above 0 a code of the NC (0x42xx, 0x4bxx).
 *   coaxle_last_error(handle) is the sentence: the field, what was received, what is expected.
 * - A handle is made by its _new function, used by one thread at a time, and freed once by its _free function. Different handles
 *   may be used by different threads, but for axes that share a coaxle_tables.
 * - A struct begins with struct_size, which the caller sets: sizeof. Structs grow at their ends, so that a program that was compiled
 *   with an older header goes on working. What a program does not set is 0.
 * - A pointer is valid for the call and points to as much as the function says. NULL and what is not aligned are errors.
 * - Memory is allocated by _new, _free and coaxle_tables_ functions alone: all others can be called in a real-time cycle. None opens
 *   a connection, starts a thread, reads a clock, takes a lock or writes a log. Only coaxle_drive_process_new and
 *   coaxle_drive_node_new open, lock and map a file.
 * - Times are ns of the caller's monotonic clock, or of the far one where stated; positions are in user units (u).
 */

#ifndef COAXLE_H
#define COAXLE_H

#include <stddef.h>
#include <stdint.h>
typedef struct coaxle_far_clock coaxle_far_clock;
typedef struct coaxle_far_axis coaxle_far_axis;
typedef struct coaxle_cycle_lock coaxle_cycle_lock;
typedef struct coaxle_encoder coaxle_encoder;
typedef struct coaxle_key coaxle_key;
typedef struct coaxle_tables coaxle_tables;
typedef struct coaxle_slave coaxle_slave;
typedef struct coaxle_receiver coaxle_receiver;
typedef struct coaxle_drive_process coaxle_drive_process;
typedef struct coaxle_drive_node coaxle_drive_node;


// Version of this interface. It grows when a function or a struct is added; what there is stays as it is.
#define COAXLE_ABI_VERSION 1

// The axis has a drive that is where it should be, without a caller's doing.
#define COAXLE_DRIVE_IDEAL 0

// The caller has a drive, and reports its actual values.
#define COAXLE_DRIVE_OF_CALLER 1

// No power.
#define COAXLE_DRIVE_OFF 0

// Power commanded, but not following yet.
#define COAXLE_DRIVE_SWITCHING_ON 1

// Following its set position.
#define COAXLE_DRIVE_FOLLOWING 2

// Failed; it stays so until its power is switched off.
#define COAXLE_DRIVE_TRIPPED 3

// `MC_Power`: switches power on.
#define COAXLE_POWER_ON 1

// `MC_Power`: switches power off after stopping the axis.
#define COAXLE_POWER_OFF 2

// `MC_Reset`: acknowledges the error of an axis that has come to rest.
#define COAXLE_RESET 3

// `MC_Home`, `MC_SetPosition`: sets the position of the axis at rest to `position`.
#define COAXLE_HOME 4

// `MC_MoveAbsolute`: moves to `position`, at up to `velocity`.
#define COAXLE_MOVE_ABSOLUTE 5

// `MC_MoveRelative`: moves by `distance`, at up to `velocity`.
#define COAXLE_MOVE_RELATIVE 6

// `MC_MoveVelocity`: ramps to `velocity`, whose sign is the direction, and keeps it.
#define COAXLE_MOVE_VELOCITY 7

// `MC_Halt`: brings the axis to rest; other commands can take over.
#define COAXLE_HALT 8

// `MC_Stop`: brings the axis to rest; only a stop that ends earlier can take over.
#define COAXLE_STOP 9

// `MC_GearIn`: couples to the master by `ratio`, on a ramp.
#define COAXLE_GEAR_IN 10

// `MC_GearInMultiMaster`, `MC_GearInDyn`, `MC_CombineAxes`: couples to the sum of masters by `ratios`.
#define COAXLE_GEAR_IN_MULTI_MASTER 11

// `MC_PhasingAbsolute`: shifts the master as the slave sees it to a lead of `distance`.
#define COAXLE_PHASING_ABSOLUTE 12

// `MC_PhasingRelative`: shifts the master by a further `distance`.
#define COAXLE_PHASING_RELATIVE 13

// `MC_MoveSuperImposed`: adds `distance` to the current motion.
#define COAXLE_MOVE_SUPERIMPOSED 14

// `MC_GearOut`: uncouples; the velocity is kept.
#define COAXLE_GEAR_OUT 15

// `MC_FlyingGear`: waits for the master, couples and releases on the fly.
#define COAXLE_FLYING_GEAR 16

// `MC_GearInPos`: the flying saw to a pair of positions.
#define COAXLE_GEAR_IN_POS 17

// `MC_GearInVelo`: the flying saw to the gear's velocity.
#define COAXLE_GEAR_IN_VELO 18

// `MC_CamIn`: couples by the plate `table`.
#define COAXLE_CAM_IN 19

// `MC_CamOut`: uncouples; the velocity is kept.
#define COAXLE_CAM_OUT 20

// `MC_CamScaling`: scales the plate.
#define COAXLE_CAM_SCALING 21

// `MC_CamIn_V2`: couples by one of several plates, or adds, exchanges, removes one: `operation`.
#define COAXLE_CAM_IN_V2 22

// `MC_CamAdd`: superposes the plate `table`.
#define COAXLE_CAM_ADD 23

// `MC_CamExchange`: replaces the plate `reference_table` by `table`.
#define COAXLE_CAM_EXCHANGE 24

// `MC_CamRemove`: removes the plate `table`.
#define COAXLE_CAM_REMOVE 25

// `MC_CamScaling_V2`: scales the plate `table`.
#define COAXLE_CAM_SCALING_V2 26

// `MC_SetCamOnlineChangeMode`: sets the activation of points of `table` that are written from now on.
#define COAXLE_SET_CAM_ONLINE_CHANGE_MODE 27

// `MC_WriteMotionFunction`, `MC_WriteMotionFunctionPoint`: replaces points of `table`.
#define COAXLE_WRITE_MOTION_FUNCTION 28

// A synchronisation position is absolute.
#define COAXLE_AT 0

// A synchronisation position is a distance ahead of the axis.
#define COAXLE_AHEAD 1

// A synchronisation position is the next passage within the modulo period.
#define COAXLE_IN_TURN 2

// `TF5055` profiles over the whole distance.
#define COAXLE_STRATEGY_NONE 0

// `mcSyncStrategyLate`.
#define COAXLE_STRATEGY_LATE 1

// `mcSyncStrategySlow`.
#define COAXLE_STRATEGY_SLOW 2

// `mcSyncStrategyEarly`.
#define COAXLE_STRATEGY_EARLY 3

// A jump of the slave is refused.
#define COAXLE_JUMP_REFUSE 0

// The slave jumps, as in the original.
#define COAXLE_JUMP_ALLOW 1

// The slave is led to its new course over `ramp_length` of the master.
#define COAXLE_JUMP_RAMP_IN 2

// `min_position` is a limit.
#define COAXLE_HAS_MIN_POSITION 1

// `max_position` is a limit.
#define COAXLE_HAS_MAX_POSITION 2

// `master_start_distance` is given.
#define COAXLE_HAS_MASTER_START_DISTANCE 4

// `DefaultSlaveNegative` of a flying gear.
#define COAXLE_DEFAULT_SLAVE_NEGATIVE 8

// `activation_position` is one within the modulo period of the master.
#define COAXLE_ACTIVATION_IN_TURN 16

// `MasterRelative` of a plate.
#define COAXLE_MASTER_RELATIVE 32

// `SlaveRelative` of a plate.
#define COAXLE_SLAVE_RELATIVE 64

// The saw's profile is one over time (`GEARINSYNCMODE_TIMEBASED`) and not over the master's position.
#define COAXLE_TIME_BASED 128

// A sum of masters makes up what a change of the ratios left behind (`POSSYNC2`).
#define COAXLE_POSSYNC2 256

// The far clock is not known yet: nothing moves.
#define COAXLE_LOCK_WAITING 0

// The deadlines are led to the far cycle.
#define COAXLE_LOCK_LOCKING 1

// The deadlines follow it.
#define COAXLE_LOCK_LOCKED 2

// The far clock is not known any more: the period stays what it was.
#define COAXLE_LOCK_HOLDOVER 3

// The cycle times are no multiples of each other, or the clocks drift by too much: nothing moves.
#define COAXLE_LOCK_REFUSED 4

// No power, or not yet.
#define COAXLE_PROCESS_OFF 0

// The drive follows its set position.
#define COAXLE_PROCESS_FOLLOWING 1

// The drive has an error, until `resets` of the set values changes.
#define COAXLE_PROCESS_ERROR 2

// Success.
#define COAXLE_OK 0

// A pointer is null where one is needed.
#define COAXLE_NULL -1

// A pointer is not aligned as its type requires.
#define COAXLE_MISALIGNED -2

// A handle is not of the expected kind, or has been freed.
#define COAXLE_NO_HANDLE -3

// A handle is in use by another thread. Only a debug build notices.
#define COAXLE_IN_USE -4

// A `struct_size` is smaller than the first version of its struct, or larger than this library's with bytes that it does not know.
#define COAXLE_STRUCT_SIZE -5

// A value is out of its range, or no number.
#define COAXLE_RANGE -6

// A text is not UTF-8, or not what it should be.
#define COAXLE_TEXT -7

// A buffer is too small.
#define COAXLE_CAPACITY -8

// A message was rejected: damaged, foreign, or of another version.
#define COAXLE_REJECTED -9

// A fault of the library itself. The handle is not usable any more.
#define COAXLE_PANIC -10

// There is nothing of the kind: an axis, a slave, a job.
#define COAXLE_NOT_THERE -11

// Mode of a far axis: the start-up mode, then sync mode (`E_Sync_FilterMode`).
#define COAXLE_MODE_AUTO 0

// As received, beats included.
#define COAXLE_MODE_BYPASS 1

// Through the PT1 filter.
#define COAXLE_MODE_PT1 2

// By the drift that the beats show: a state only, reached in `COAXLE_MODE_AUTO`.
#define COAXLE_MODE_SYNC 3

// Beats are hidden when they happen.
#define COAXLE_MODE_TIME 4

// By the correction of a far clock; the start-up mode bridges until that is sure.
#define COAXLE_MODE_OBSERVER 5

// Set values are those of the master.
#define COAXLE_FOLLOWING 0

// Without a master: the axis is braked, or at rest.
#define COAXLE_BRAKING 1

// The axis is brought back to its master.
#define COAXLE_REJOINING 2

// An age limit that is left to the library: 7 own cycles; in mode observer as many as 100 ms take, and 7 of the far node.
#define COAXLE_AGE_BY_DEFAULT UINT32_MAX

// The delay of messages is not compensated: far time lags by it.
#define COAXLE_DELAY_OFF 0

// The delay is `delay_ns`.
#define COAXLE_DELAY_FIXED 1

// The delay is measured by requests and responses.
#define COAXLE_DELAY_MEASURED 2

// Too few messages to say anything.
#define COAXLE_STARTUP 0

// There is a far time that may still move fast.
#define COAXLE_LOCKING 1

// The far time is sure.
#define COAXLE_SYNCED 2

// The far time was sure, and is uncertain now.
#define COAXLE_UNSURE 3

// No messages lately: it goes on by the last estimate.
#define COAXLE_HOLDOVER 4

// No messages for too long.
#define COAXLE_LOST 5

// Greatest number of pieces of a plan.
#define COAXLE_MOST_PIECES 8

// Greatest number of plans in a message.
#define COAXLE_MOST_PLANS 8

// Greatest number of masters of a slave axis.
#define COAXLE_MOST_MASTERS 4

// No job of this number, or none any more.
#define COAXLE_JOB_NONE 0

// Accepted, not yet in control of the axis.
#define COAXLE_JOB_WAITING 1

// In control of the axis, not yet at its goal.
#define COAXLE_JOB_ACTIVE 2

// Following its master.
#define COAXLE_JOB_IN_SYNC 3

// Finished.
#define COAXLE_JOB_DONE 4

// Aborted by another command, or by the end of the coupling.
#define COAXLE_JOB_ABORTED 5

// Refused or failed.
#define COAXLE_JOB_FAILED 6

// Without power.
#define COAXLE_DISABLED 0

// Powered, at rest, without a job.
#define COAXLE_STANDSTILL 1

// Finding its position.
#define COAXLE_HOMING 2

// On its way to a standstill: at a position, or by a halt.
#define COAXLE_DISCRETE_MOTION 3

// At a velocity, without an end.
#define COAXLE_CONTINUOUS_MOTION 4

// Coupled to a master.
#define COAXLE_SYNCHRONIZED_MOTION 5

// Stopping; only a harder stop or the loss of power can interrupt it.
#define COAXLE_STOPPING 6

// In error, until reset.
#define COAXLE_ERROR_STOP 7

// Greatest number of axes in a frame.
#define COAXLE_MOST_AXES 128

// A buffer of this size, in bytes, holds every message.
#define COAXLE_MOST_BYTES 20000

// A point of a motion function (`MC_MotionFunctionPoint`, TF5050). It does not grow.
typedef struct coaxle_motion_point {
  // Number of the point, from 1.
  uint32_t index;
  // Motion law to the next point (`FunctionType`), by its number in TF5050.
  uint32_t function;
  // Type of the point (`PointType`), by its number in TF5050.
  uint32_t point_type;
  // Number of rows to the next point, 1 unless points are skipped.
  int32_t relative_next;
  // Position of the master, x.
  double master;
  // Position of the slave, u.
  double slave;
  // Velocity of the slave, u/x.
  double velocity;
  // Acceleration of the slave, u/x².
  double acceleration;
  // Jerk of the slave, u/x³.
  double jerk;
} coaxle_motion_point;

// A command. `coaxle_command_init` sets all fields to what they are unless stated; a command looks at its own alone.
typedef struct coaxle_command {
  // `sizeof` this struct.
  uint32_t struct_size;
  // `COAXLE_POWER_ON` to `COAXLE_WRITE_MOTION_FUNCTION`.
  uint32_t kind;
  // `COAXLE_HAS_MIN_POSITION` to `COAXLE_POSSYNC2`, added up.
  uint32_t flags;
  // Number of `ratios` that are given, 1 to 4.
  uint32_t number_of_ratios;
  // Target position, u.
  double position;
  // Distance or shift, u.
  double distance;
  // Velocity, u/s; 0: the limit of the axis.
  double velocity;
  // Acceleration, u/s²; 0: the limit of the axis.
  double acceleration;
  // Deceleration, u/s²; 0: the limit of the axis.
  double deceleration;
  // Jerk, u/s³; 0: the limit of the axis.
  double jerk;
  // Lowest position of a synchronisation, u, with `COAXLE_HAS_MIN_POSITION`.
  double min_position;
  // Highest position of a synchronisation, u, with `COAXLE_HAS_MAX_POSITION`.
  double max_position;
  // Slave units per master unit (`RatioNumerator`).
  double ratio;
  // Slave units per unit of each master.
  double ratios[4];
  // Denominator of the ratio of a saw, 1 to 65535.
  uint32_t ratio_denominator;
  // `GearInSync_CheckMask_…` and `GearInSync_OpMask_…`, TF5055.
  uint32_t sync_mask;
  // `COAXLE_STRATEGY_NONE` to `COAXLE_STRATEGY_EARLY`.
  uint32_t strategy;
  // `COAXLE_AT`, `COAXLE_AHEAD` or `COAXLE_IN_TURN`, of `master_sync_position`.
  uint32_t master_sync_kind;
  // `COAXLE_AT`, `COAXLE_AHEAD` or `COAXLE_IN_TURN`, of the positions of the slave.
  uint32_t slave_sync_kind;
  // 0.
  uint32_t reserved;
  // Synchronisation position of the master, u of the master.
  double master_sync_position;
  // Synchronisation position of the slave, u.
  double slave_sync_position;
  // Distance of the master before its position at which the synchronisation begins, u, with `COAXLE_HAS_MASTER_START_DISTANCE`.
  double master_start_distance;
  // Expected velocity of a master that stands, u/s; 0: none.
  double master_velocity;
  // Position at which the release of a flying gear begins, u.
  double slave_desync_position;
  // Position at which it stands, u.
  double slave_stop_position;
  // Plate, 1 to 255; 0: the only one.
  uint32_t table;
  // Plate that it refers to.
  uint32_t reference_table;
  // `CAMOPERATIONMODE_…`, 0 to 3.
  uint32_t operation;
  // `MC_STARTMODE_…`, 1 to 4.
  uint32_t start_mode;
  // `MC_CAMACTIVATION_…`, 0 to 9.
  uint32_t activation_mode;
  // `COAXLE_JUMP_REFUSE` to `COAXLE_JUMP_RAMP_IN`.
  uint32_t jump;
  // Position of the master at the activation.
  double activation_position;
  // Distance of the master on which the slave is led to a new course, u.
  double ramp_length;
  // `MC_CAMSCALING_…` of the master, 0 to 2.
  uint32_t master_scaling_mode;
  // `MC_CAMSCALING_…` of the slave, 0 to 2.
  uint32_t slave_scaling_mode;
  // Offset of the master, u.
  double master_offset;
  // Offset of the slave, u.
  double slave_offset;
  // Scaling of the master, not 0.
  double master_scaling;
  // Scaling of the slave.
  double slave_scaling;
  // Number of `points`, 1 to 4.
  uint32_t number_of_points;
  // 0.
  uint32_t reserved_too;
  // Points to write.
  struct coaxle_motion_point points[4];
} coaxle_command;

// A far cycle in relation to the own one, at the ideal start of an own cycle.
typedef struct coaxle_far_phase {
  // `sizeof` this struct.
  uint32_t struct_size;
  // 0.
  uint32_t reserved;
  // Age of any message by the far clock, s.
  double age_s;
  // Delay of messages as far as the far clock knows it, s; 0 for one that counts from arrivals.
  double delay_s;
  // Drift of the far clock against the own one, ppm.
  double drift_ppm;
  // Nominal cycle time of the far node, ns.
  int64_t cycle_time_ns;
} coaxle_far_phase;

// Set values of a cycle of the node, for the process of a drive.
typedef struct coaxle_drive_set_values {
  // `sizeof` this struct.
  uint32_t struct_size;
  // 1: switch power on and follow; 0: no power, and the other set values are undefined.
  uint32_t is_enabled;
  // Incremented in each cycle of the node.
  uint64_t counter;
  // Ideal start of that cycle, ns of `CLOCK_MONOTONIC`: the instant of the set values.
  int64_t ideal_start_ns;
  // Set position, u.
  double position;
  // Set velocity, u/s.
  double velocity;
  // Set acceleration, u/s².
  double acceleration;
  // A changed number: acknowledge errors.
  uint64_t resets;
} coaxle_drive_set_values;

// Actual values of a drive, as its process reports them.
typedef struct coaxle_drive_values {
  // `sizeof` this struct.
  uint32_t struct_size;
  // `COAXLE_PROCESS_OFF` to `COAXLE_PROCESS_ERROR`.
  uint32_t state;
  // Error code of the drive, 0 without an error.
  uint32_t error;
  // 0.
  uint32_t reserved;
  // Counter of the set values that were read.
  uint64_t counter;
  // Number of `resets` that was executed.
  uint64_t resets;
  // Actual position, u.
  double position;
  // Actual velocity, u/s.
  double velocity;
} coaxle_drive_values;

// Parameters of the node's end.
typedef struct coaxle_drive_memory_parameters {
  // `sizeof` this struct.
  uint32_t struct_size;
  // Axis id of the slave.
  uint32_t axis_id;
  // Number of this run of the node, any other than the one before.
  uint64_t run;
  // Nominal cycle time of the node, ns.
  int64_t cycle_time_ns;
  // Cycles without a heartbeat of the process, 1 to 100 000.
  uint32_t max_silent_cycles;
  // Cycles from the request for power until the drive must follow.
  uint32_t switch_on_cycles;
  // Largest following error, u; above 0.
  double following_error_window;
  // Time for which it may be exceeded, s.
  double following_error_time_s;
} coaxle_drive_memory_parameters;

// A cycle of the node.
typedef struct coaxle_drive_memory_command {
  // `sizeof` this struct.
  uint32_t struct_size;
  // Other than 0: switch power on and follow.
  uint32_t wants_power;
  // Ideal start of the cycle, ns of `CLOCK_MONOTONIC`.
  int64_t ideal_start_ns;
  // Time since the cycle before, s.
  double elapsed_s;
  // Set position, u.
  double position;
  // Set velocity, u/s.
  double velocity;
  // Set acceleration, u/s².
  double acceleration;
} coaxle_drive_memory_command;

// Actual values of a drive.
typedef struct coaxle_actual {
  // `sizeof` this struct.
  uint32_t struct_size;
  // `COAXLE_DRIVE_OFF` to `COAXLE_DRIVE_TRIPPED`.
  uint32_t state;
  // Actual position, u.
  double position;
  // Actual velocity, u/s.
  double velocity;
  // Set minus actual position, u.
  double following_error;
} coaxle_actual;

// Parameters of the master of an encoder. `coaxle_encoder_parameters_init` sets all but the increment.
typedef struct coaxle_encoder_parameters {
  // `sizeof` this struct.
  uint32_t struct_size;
  // Width of the counter, 8 to 64 bits.
  uint32_t counter_bits;
  // Cycle time of the set values, ns: 100 000 to 100 000 000.
  int64_t cycle_time_ns;
  // Length of one count, u.
  double increment;
  // Cycle time in which the counter is read, s; 0: that of the set values.
  double sampling_time_s;
  // Time constant of the smoothing, s; 0: the best for the increment.
  double smoothing_s;
  // Speed that the axis never exceeds, u/s. A count that needs 1.5 times as much is refused.
  double max_speed;
  // Standard deviation of the shaft's vibration, u.
  double vibration;
  // Standard deviation of the instants at which the counter is read, s.
  double timing_sigma_s;
  // Largest acceleration of the set values, u/s².
  double acceleration_limit;
  // Largest jerk of the set values, u/s³.
  double jerk_limit;
  // Largest speed at which a master at rest too far ahead walks back, u/s.
  double trim_speed;
} coaxle_encoder_parameters;

// A reading of the counter. It does not grow.
typedef struct coaxle_encoder_sample {
  // The count. Bits beyond the width of the counter are ignored; a signed one is passed as its two's complement.
  uint64_t count;
  // Sampling cycles since the sample before: 1, or more after lost ones. The sample of 0 cycles is the last one again.
  uint32_t cycles;
  // 0.
  uint32_t reserved;
} coaxle_encoder_sample;

// Set values of the master of an encoder, and what is known about them.
typedef struct coaxle_encoder_state {
  // `sizeof` this struct.
  uint32_t struct_size;
  // Current or last direction: 1, -1, or 0 before the first motion.
  int32_t direction;
  // Other than 0 if no edge has come for a quarter of a second, or none that is a motion.
  uint32_t is_standstill;
  // Other than 0 while the set values walk back to the position of the axis at rest.
  uint32_t is_trimming;
  // Other than 0 once the set values have settled and keep their limits.
  uint32_t is_acquired;
  // Refused counts that no motion explains.
  uint32_t refused_jumps;
  // Presets of the counter.
  uint32_t counter_resets;
  // 0.
  uint32_t reserved;
  // Set position, u.
  double position;
  // Set velocity, u/s.
  double velocity;
  // Set acceleration, u/s².
  double acceleration;
  // Standard deviation of the estimated position, u.
  double position_sigma;
  // Standard deviation of the estimated velocity, u/s.
  double velocity_sigma;
} coaxle_encoder_state;

// Parameters of a far axis: `ST_AxisSyncParameters`. `coaxle_far_axis_parameters_init` sets them to the manual's defaults.
typedef struct coaxle_far_axis_parameters {
  // `sizeof` this struct.
  uint32_t struct_size;
  // `COAXLE_MODE_AUTO`, `_BYPASS`, `_PT1`, `_TIME` or `_OBSERVER` (`eFilterMode`).
  uint32_t mode;
  // Own nominal cycle time, ns: 100 000 to 100 000 000.
  int64_t cycle_time_ns;
  // That of the far node, ns; 0: the own one. One is a whole multiple of the other (`fDataCycleTime`).
  int64_t data_cycle_time_ns;
  // Until the drift is known: `COAXLE_MODE_BYPASS`, `_PT1` or `_TIME` (`eStartUpMode`).
  uint32_t start_up_mode;
  // After an error: `COAXLE_MODE_BYPASS` or `_PT1` (`eFallBackMode`).
  uint32_t fall_back_mode;
  // Most own cycles in a row without a new sample, 1 to 65 535; 0: any number; or `COAXLE_AGE_BY_DEFAULT` (`iAgeOfDataLimit`).
  uint32_t age_of_data_limit;
  // The drift is the mean over this many periods between beats, 1 to 64 (`iNoOfPeriodsForMeanDrift`).
  uint32_t periods_for_mean_drift;
  // Cycles for which the offset must stay constant to make a plateau, at least 1 (`iEndOfTransitionLimit`).
  uint32_t end_of_transition_limit;
  // Cycles over which old and new ramp are blended after a beat (`iNewDriftBendingCycles`).
  uint32_t new_drift_bending_cycles;
  // Cycles over which time mode takes a beat's difference away (`iTimeModeBlendingCycles`).
  uint32_t time_mode_blending_cycles;
  // Other than 0: stay in time mode (`bForceTimeMode`).
  uint32_t force_time_mode;
  // Other than 0: start up again by itself, one cycle after a fault (`bAutomaticReInit`).
  uint32_t automatic_re_init;
  // Other than 0: extrapolate with the acceleration, too (`bUseAccForExtrapolation`).
  uint32_t use_acceleration;
  // Correction time, in own cycles, below which sync mode may begin; above 0 (`fThresholdForSync`).
  double threshold_for_sync;
  // Largest difference between corrected and received index; 0: any (`fMaxCycleIndexDifference`).
  double max_cycle_index_difference;
  // Added to the correction time, s; positive: further into the future (`fDelayTimeOffset`).
  double delay_time_offset_s;
  // Part of a beat's correction in the first section after it, 0 to 1 (`fSlope1Numerator`).
  double slope1_numerator;
  // Length of that section as a part of the time between beats, above 0, below 1 (`fSlope1Denominator`).
  double slope1_denominator;
  // Largest difference between received and calculated position, u; 0: any (`fMaxPositionDiff`).
  double max_position_diff;
  // Time constant of the PT1 filter of the position, own cycles; 0: none (`fT1factorPos`).
  double t1_factor_pos;
  // That of the velocity (`fT1factorVelo`).
  double t1_factor_velo;
  // Time over which a change of mode is blended, s (`fBlendingTime`).
  double blending_time_s;
  // Other than 0: without steps. An axis whose node is silent is braked, and is brought back along a curve when that returns, restarts
  // or is shown by another delay. 0: as `FB_AxisSync`, which blends changes of the mode and jumps to what it receives after a silence.
  uint32_t is_continuous;
  // 0.
  uint32_t reserved;
} coaxle_far_axis_parameters;

// Sample of a far axis in a frame.
typedef struct coaxle_far_sample {
  // `sizeof` this struct.
  uint32_t struct_size;
  // 0.
  uint32_t reserved;
  // Cycle count of the far node.
  uint64_t count;
  // Time after its generation at which it is shown, ns, as the frame's header states it; 0: it is moved to now.
  int64_t present_after_ns;
  // Set position, u.
  double position;
  // Set velocity, u/s.
  double velocity;
  // Set acceleration, u/s².
  double acceleration;
} coaxle_far_sample;

// A piece of a planned motion, with constant jerk. It does not grow.
typedef struct coaxle_motion_piece {
  // Begin of the piece, ns of the node's run: cycle count times cycle time.
  int64_t start_ns;
  // Duration of the piece, ns, above 0.
  int64_t duration_ns;
  // Position at its begin, u.
  double position;
  // Velocity at its begin, u/s.
  double velocity;
  // Acceleration at its begin, u/s².
  double acceleration;
  // Jerk, u/s³.
  double jerk;
} coaxle_motion_piece;

// The planned motion of an axis, and its promise. It does not grow.
typedef struct coaxle_plan {
  // Cycle count of the node when it made the plan.
  uint64_t count;
  // The axis id.
  uint32_t axis_id;
  // Number of pieces, 1 to `COAXLE_MOST_PIECES`.
  uint32_t number;
  // Until then the axis does not deviate from the plan, ns of the node's run: within its pieces.
  int64_t promised_until_ns;
  // Largest velocity of the axis, u/s.
  double max_velocity;
  // Largest acceleration of the axis, u/s².
  double max_acceleration;
  // Largest deceleration of the axis, u/s².
  double max_deceleration;
  // Largest jerk of the axis, u/s³.
  double max_jerk;
  // The pieces, one after the other without a gap or a jump.
  struct coaxle_motion_piece pieces[COAXLE_MOST_PIECES];
} coaxle_plan;

// Set values of a far axis, and how they came about.
typedef struct coaxle_far_axis_state {
  // `sizeof` this struct.
  uint32_t struct_size;
  // `COAXLE_MODE_BYPASS` to `COAXLE_MODE_OBSERVER`: what calculated them (`eFilterState`).
  uint32_t mode;
  // Other than 0 if the far clock is known and corrected, and nothing is wrong (`bSynced`).
  uint32_t is_synced;
  // Other than 0 if samples have been missing for longer than the age limit.
  uint32_t is_silent;
  // Other than 0 if they lie between two frames that are shown later.
  uint32_t is_interpolated;
  // Other than 0 if they are those of the plan.
  uint32_t is_planned;
  // Error, a code of TS5066; 0: none (`iErrorId`).
  uint32_t error;
  // Warning, a code of TS5066; 0: none.
  uint32_t warning;
  // Beats (`iCountBeats`).
  uint32_t beats;
  // Samples that contradicted the plan.
  uint32_t plan_contradictions;
  // Set position, u.
  double position;
  // Set velocity, u/s.
  double velocity;
  // Set acceleration, u/s².
  double acceleration;
  // Time by which the newest sample was moved, s; not a number in a mode without one (`fCorrectionTime`).
  double correction_s;
  // Time by which the axis is shown later, s; 0: its newest sample is moved to now.
  double shown_later_s;
  // Time from the instant shown to the end of the promise, s; not a number without one.
  double promised_ahead_s;
  // Received minus calculated position, u (`fPositionDiff`).
  double position_diff;
  // Received minus calculated velocity, u/s (`fVeloDiff`).
  double velocity_diff;
  // `COAXLE_FOLLOWING`, `COAXLE_BRAKING` or `COAXLE_REJOINING`, of an axis without steps.
  uint32_t continuity;
  // 0.
  uint32_t reserved;
} coaxle_far_axis_state;

// A position that a planned axis comes to. It does not grow.
typedef struct coaxle_awaited_position {
  // The position, u.
  double position;
  // Period in which it repeats, u, above 0; 0: that position alone.
  double modulo;
  // 1 or -1: the direction in which the axis comes to it; 0: any.
  int32_t direction;
  // 0.
  uint32_t reserved;
} coaxle_awaited_position;

// Parameters of a far clock.
typedef struct coaxle_far_clock_parameters {
  // `sizeof` this struct.
  uint32_t struct_size;
  // `COAXLE_DELAY_OFF`, `COAXLE_DELAY_FIXED` or `COAXLE_DELAY_MEASURED`.
  uint32_t delay_source;
  // Nominal cycle time of the far node, ns: 100 000 to 100 000 000.
  int64_t cycle_time_ns;
  // A fixed delay, ns: within a second, forwards and backwards.
  int64_t delay_ns;
  // Number of this run of the own node, which its requests carry: random, say.
  uint64_t run;
} coaxle_far_clock_parameters;

// A message of the far node.
typedef struct coaxle_message {
  // `sizeof` this struct.
  uint32_t struct_size;
  // Other than 0 if `send_stamp_ns` is stated.
  uint32_t has_send_stamp;
  // Run of the far node: another one is another clock.
  uint64_t epoch;
  // Cycle count of the far node.
  uint64_t count;
  // Arrival, ns of the own clock.
  int64_t arrived_ns;
  // Departure after the ideal start of its cycle, ns of the far clock.
  int64_t send_stamp_ns;
} coaxle_message;

// A response to a request of the own node, or an exchange of a timing channel. It does not grow.
typedef struct coaxle_time_response {
  // Run of the own node.
  uint64_t run;
  // Run of the far node.
  uint64_t epoch;
  // Departure of the request, ns of the own clock.
  int64_t requested_ns;
  // Arrival of the request, ns of the far clock since the ideal start of its cycle 0.
  int64_t received_ns;
  // Departure of the response, likewise.
  int64_t responded_ns;
  // Number of the request.
  uint32_t number;
  // 0.
  uint32_t reserved;
} coaxle_time_response;

// Readings of a time that both nodes have in common (PTP, TAI), in one exchange.
typedef struct coaxle_common_time {
  // `sizeof` this struct.
  uint32_t struct_size;
  // 1: there is an own reading, 2: there is one of the far node, 3: both.
  uint32_t readings;
  // Own clock at the own reading, ns.
  int64_t here_ns;
  // Common time that was read here, ns.
  int64_t own_time_ns;
  // Greatest error of that time against the grandmaster, ns.
  int64_t own_bound_ns;
  // Identity of the grandmaster.
  uint64_t own_grandmaster;
  // Run of the far node.
  uint64_t epoch;
  // Far clock at the far reading, ns since the ideal start of its cycle 0.
  int64_t there_ns;
  // Common time that was read there, ns.
  int64_t far_time_ns;
  // Greatest error of that time against the grandmaster, ns.
  int64_t far_bound_ns;
  // Identity of the grandmaster.
  uint64_t far_grandmaster;
} coaxle_common_time;

// Far time, and what is known about it.
typedef struct coaxle_far_time {
  // `sizeof` this struct.
  uint32_t struct_size;
  // `COAXLE_STARTUP` to `COAXLE_LOST`.
  uint32_t state;
  // Other than 0 if there is a far time.
  uint32_t is_known;
  // Other than 0 if far time is sure, or was and goes on as it did.
  uint32_t is_sure;
  // Far time, ns since the ideal start of the far node's cycle 0.
  int64_t time_ns;
  // Rest beyond whole nanoseconds, ns: 0 to below 1.
  double fraction_ns;
  // Greatest error as far as is known, s.
  double uncertainty_s;
  // Rate of the far clock against the own one, ppm.
  double drift_ppm;
  // Standard deviation of the drift, ppm.
  double drift_sigma_ppm;
  // Standard deviation of the estimated offset, s.
  double offset_sigma_s;
  // Delay in use, s; not a number without one.
  double delay_s;
  // Greatest error of the delay, s; not a number if it is not measured.
  double delay_uncertainty_s;
} coaxle_far_time;

// Parameters of a receiver beside its config.
typedef struct coaxle_receiver_parameters {
  // `sizeof` this struct.
  uint32_t struct_size;
  // `COAXLE_DRIVE_IDEAL`: the drives of the config, which are simulated. `COAXLE_DRIVE_OF_CALLER`: the caller has a drive for each
  // slave, which therefore needs limits.
  uint32_t drive;
  // Start of its first cycle, ns of the own clock.
  int64_t start_ns;
  // Number of this run: random.
  uint64_t epoch;
} coaxle_receiver_parameters;

// The NC-to-PLC axis structure (`NCTOPLC_AXLESTRUCT`) as it is in frames, in user units (u). It does not grow.
typedef struct coaxle_axis {
  // The state word (`nStateDWord`).
  uint32_t state_word;
  // NC error code (`nErrorCode`), 0: none.
  uint32_t error_code;
  // State of the motion (`nAxisState`).
  uint32_t axis_state;
  // Confirmed axis mode (`nAxisModeCon`).
  uint32_t axis_mode;
  // State of the reference run (`nCalibrationState`).
  uint32_t calibration_state;
  // Role in couplings (`nCoupleState`).
  uint32_t couple_state;
  // Commands waiting in the preparation table (`nSvbEntries`).
  uint32_t svb_entries;
  // Commands waiting in the execution table (`nSafEntries`).
  uint32_t saf_entries;
  // Axis id on its controller (`nAxisId`).
  uint32_t axis_id;
  // Operation mode word (`nOpModeDWord`).
  uint32_t op_mode;
  // Control loop in use (`nActiveControlLoopIndex`).
  uint16_t active_control_loop;
  // Requested control loop (`nControlLoopIndex`).
  uint16_t control_loop;
  // Whole modulo periods of the actual position (`nModuloTurns`).
  int32_t modulo_actual_turns;
  // Actual position (`fPosIst`), u.
  double actual_position;
  // Actual position within one modulo period (`fModuloPosIst`), u.
  double modulo_actual_position;
  // Actual velocity (`fVeloIst`), u/s.
  double actual_velocity;
  // Following error (`fPosDiff`), u.
  double following_error;
  // Set position (`fPosSoll`), u.
  double set_position;
  // Set velocity (`fVeloSoll`), u/s.
  double set_velocity;
  // Set acceleration (`fAccSoll`), u/s².
  double set_acceleration;
  // Target position of the current command (`TargetPos`), u.
  double target_position;
  // Set position within one modulo period (`ModuloSetPos`), u.
  double modulo_set_position;
  // Whole modulo periods of the set position (`ModuloSetTurns`).
  int32_t modulo_set_turns;
  // Number of the current command (`CmdNo`).
  uint16_t command_number;
  // State of the current command (`CmdState`).
  uint16_t command_state;
} coaxle_axis;

// Set values of a slave axis, and its state.
typedef struct coaxle_slave_state {
  // `sizeof` this struct.
  uint32_t struct_size;
  // `COAXLE_DISABLED` to `COAXLE_ERROR_STOP`.
  uint32_t status;
  // Set position, u.
  double position;
  // Set velocity, u/s.
  double velocity;
  // Set acceleration, u/s².
  double acceleration;
  // Distance that its limits leave between it and its coupling, u.
  double distance;
  // NC error code, 0: none.
  uint32_t error;
  // Other than 0 if it wants its drive to have power.
  uint32_t wants_power;
  // Other than 0 if it is coupled and in sync.
  uint32_t is_in_sync;
  // 0: its set values are those of its motion; 1: coasting; 2: catching up; 3: its target is beyond its limits.
  uint32_t tracking;
  // Number of presets of its position, by homing or power: its set position may have stepped by one.
  uint32_t presets;
  // 0.
  uint32_t reserved;
} coaxle_slave_state;

// Parameters of a slave axis.
typedef struct coaxle_slave_parameters {
  // `sizeof` this struct.
  uint32_t struct_size;
  // `COAXLE_HAS_MIN_POSITION`, `COAXLE_HAS_MAX_POSITION`: its software limits.
  uint32_t flags;
  // Cycle time, ns: 100 000 to 100 000 000.
  int64_t cycle_time_ns;
  // Highest speed, u/s.
  double velocity;
  // Highest acceleration, u/s².
  double acceleration;
  // Highest deceleration, u/s²; 0: that of the acceleration.
  double deceleration;
  // Highest jerk, u/s³; 0: unlimited.
  double jerk;
  // Lower software limit, u.
  double min_position;
  // Upper software limit, u.
  double max_position;
  // Modulo period of the axis, u; 0: none.
  double modulo;
  // Modulo period of its first master, u; 0: none.
  double master_modulo;
  // Axis id in cam plates and saw tables, 1 to 255; 0: neither plates nor saw tables.
  uint32_t axis_id;
  // Id of its first master.
  uint32_t master_axis_id;
  // Reaction to the loss of a master. 0: stop within the limits; 1: stop with full deceleration; 2: continued following.
  uint32_t on_master_loss;
  // `COAXLE_DRIVE_IDEAL` or `COAXLE_DRIVE_OF_CALLER`.
  uint32_t drive;
} coaxle_slave_parameters;

// A master in one cycle. It does not grow.
typedef struct coaxle_master {
  // Position, u of the master.
  double position;
  // Velocity, u/s.
  double velocity;
  // Acceleration, u/s².
  double acceleration;
  // Other than 0 if it is there; 0 if it is lost or in error.
  uint32_t is_there;
  // 0.
  uint32_t reserved;
} coaxle_master;

// A request for the time of a clock. It does not grow.
typedef struct coaxle_time_request {
  // Requester: `coaxle_sender_id` of its node name.
  uint32_t requester;
  // Number of the request in its run.
  uint32_t number;
  // Run of the requester.
  uint64_t run;
  // Departure of the request, ns of the requester's clock.
  int64_t requested_ns;
  // Arrival of the request, ns of the responder's clock since the ideal start of its cycle 0; the responder fills it in.
  int64_t received_ns;
} coaxle_time_request;

// Everything of a frame besides its axes.
typedef struct coaxle_frame_header {
  // `sizeof` this struct.
  uint32_t struct_size;
  // Sender: `coaxle_sender_id` of its node name.
  uint32_t sender;
  // Run of the sender, drawn at random when it starts.
  uint64_t epoch;
  // Cycle count of the sender since then.
  uint64_t count;
  // Nominal cycle time of the sender, ns.
  int64_t cycle_time_ns;
  // Time after the ideal start of its cycle at which the axes are shown, ns; 0: their newest values are moved to now.
  int64_t present_after_ns;
  // Departure after the ideal start of its cycle, ns of the sender's clock.
  int64_t send_stamp_ns;
  // Other than 0 if the departure is stated.
  uint32_t has_send_stamp;
  // 0.
  uint32_t reserved;
} coaxle_frame_header;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Returns the version of the interface of the library that is loaded: at least that of the header.
uint32_t coaxle_abi_version(void);

// Returns the sentence of the newest error of a handle, which stays until its next one. For `NULL`: of the newest error of this thread
// without a handle, as of a `_new` function.
// `handle` is `NULL` or one of this library, not freed yet.
const char *coaxle_last_error(const void *handle);

// Sets all fields of a command to what they are unless stated, but for its `struct_size`, which the caller has set.
int32_t coaxle_command_init(struct coaxle_command *command, uint32_t kind);

// Makes the lock of a thread with this nominal cycle time, ns, whose cycles are to begin `offset_ns` after the messages have
// arrived.
int32_t coaxle_cycle_lock_new(int64_t cycle_time_ns,
                              int64_t offset_ns,
                              coaxle_cycle_lock **out);

// Frees a lock; `NULL` is left alone.
void coaxle_cycle_lock_free(coaxle_cycle_lock *lock);

// Takes the phase at the start of a cycle, `elapsed` cycles after the one before, and passes out by how many ns the next deadline is
// to be moved. `phase` is `NULL` while the far clock is not known.
int32_t coaxle_cycle_lock_advance(coaxle_cycle_lock *lock,
                                  const struct coaxle_far_phase *phase,
                                  uint32_t elapsed,
                                  int64_t *moved_ns);

// Passes out the state of a lock, the time by which the newest cycle began later than wanted (s; not a number while the far clock is
// not known) and the change of the period (ppm). Each of the three may be `NULL`.
int32_t coaxle_cycle_lock_state(coaxle_cycle_lock *lock,
                                uint32_t *state,
                                double *phase_s,
                                double *period_ppm);

// Attaches to the memory that a running node has created at `path`: opens, locks and maps the file. One process is attached at a time.
//
// # Errors
// `COAXLE_NOT_THERE` without a running node, or with another process attached: later it may succeed. `COAXLE_REJECTED` for a file
// that is no memory of a drive, or that may not be used.
int32_t coaxle_drive_process_new(const char *path,
                                 coaxle_drive_process **out);

// Reports to the node that no process is attached, and frees the handle; `NULL` is left alone.
void coaxle_drive_process_free(coaxle_drive_process *process);

// Passes out the name of the slave, which stays until the handle is freed, its axis id, and the nominal cycle time of the node, ns. Each
// of the three may be `NULL`.
int32_t coaxle_drive_process_slave(coaxle_drive_process *process,
                                   const char **name,
                                   uint32_t *axis_id,
                                   int64_t *cycle_time_ns);

// Passes out the newest set values.
//
// # Errors
// `COAXLE_NOT_THERE` while they are being written, when the previous ones stay in force; and after the end of the node, when
// `is_attached` is 0: free the handle, and attach again.
int32_t coaxle_drive_process_read(coaxle_drive_process *process,
                                  uint32_t *is_attached,
                                  struct coaxle_drive_set_values *out);

// Reports the actual values of the drive. Each call is a heartbeat of the process.
int32_t coaxle_drive_process_report(coaxle_drive_process *process, const struct coaxle_drive_values *values);

// Creates the memory of a slave at `path`, on a file system in memory, or takes over the one of an earlier node that has crashed.
// `name` is that of the slave.
//
// # Errors
// `COAXLE_REJECTED` for a file that another node uses, that is something else, or to which others have any right.
int32_t coaxle_drive_node_new(const struct coaxle_drive_memory_parameters *parameters,
                              const char *path,
                              const char *name,
                              coaxle_drive_node **out);

// Reports the end of the node to the process, removes the file, and frees the handle; `NULL` is left alone.
void coaxle_drive_node_free(coaxle_drive_node *node);

// Hands the set values of a cycle over, and passes out the actual values of the drive, as `coaxle_slave_report_actual` and
// `coaxle_receiver_report_actual` take them. `out` may be `NULL`. A drive that has tripped stays so until `wants_power` has been 0.
int32_t coaxle_drive_node_step(coaxle_drive_node *node,
                               const struct coaxle_drive_memory_command *command,
                               struct coaxle_actual *out);

// Sets the parameters of an encoder with this increment (u), at this cycle time (ns), to their defaults, but for `struct_size`, which
// the caller has set. The defaults are for axes in millimetres.
int32_t coaxle_encoder_parameters_init(struct coaxle_encoder_parameters *parameters,
                                       double increment,
                                       int64_t cycle_time_ns);

// Makes the master of an encoder, and passes it out in `out`.
int32_t coaxle_encoder_new(const struct coaxle_encoder_parameters *parameters, coaxle_encoder **out);

// Frees the master of an encoder; `NULL` is left alone.
void coaxle_encoder_free(coaxle_encoder *encoder);

// Runs a cycle, `elapsed` cycles after the one before.
//
// `sample` is the new reading, `NULL` without one. The set values belong to the instant `horizon_s` after the newest reading, which is
// a cycle more with every cycle without one. `state` may be `NULL`.
int32_t coaxle_encoder_update(coaxle_encoder *encoder,
                              const struct coaxle_encoder_sample *sample,
                              double horizon_s,
                              uint32_t elapsed,
                              struct coaxle_encoder_state *state);

// Forgets where the encoder was: the next reading is the first one.
int32_t coaxle_encoder_restart(coaxle_encoder *encoder);

// Sets the parameters of a far axis to the defaults of the manual, but for `struct_size`, which the caller has set: mode observer, with
// this own cycle time and that of the far node, ns.
int32_t coaxle_far_axis_parameters_init(struct coaxle_far_axis_parameters *parameters,
                                        int64_t cycle_time_ns,
                                        int64_t data_cycle_time_ns);

// Makes a far axis, and passes it out in `out`.
int32_t coaxle_far_axis_new(const struct coaxle_far_axis_parameters *parameters, coaxle_far_axis **out);

// Frees a far axis; `NULL` is left alone.
void coaxle_far_axis_free(coaxle_far_axis *axis);

// Takes the sample of a frame. An older one than the newest counts for an axis that is shown later alone. Before the first one of
// another run of the node (another epoch) call `coaxle_far_axis_restart`.
int32_t coaxle_far_axis_sample(coaxle_far_axis *axis,
                               const struct coaxle_far_sample *sample);

// Takes a plan of its node, which is used where samples are missing, once a sample has confirmed it and its renewals have reached far
// enough for a second. An older one than the newest is left out.
//
// # Errors
// `COAXLE_REJECTED` and the reason: no motion that an axis can make, or a promise that is moved back or broken.
int32_t coaxle_far_axis_plan(coaxle_far_axis *axis,
                             const struct coaxle_plan *plan);

// Runs a cycle, `elapsed` cycles after the one before. `state` may be `NULL`.
//
// In mode observer `correction_s` is that of a far clock for the newest sample's count (`coaxle_far_clock_correction`): `NULL` while it
// is not sure. The other modes count cycles, and do not read it.
//
// # Errors
// `COAXLE_NOT_THERE` before the first sample.
int32_t coaxle_far_axis_cycle(coaxle_far_axis *axis,
                              const double *correction_s,
                              uint32_t elapsed,
                              struct coaxle_far_axis_state *state);

// Passes out the instant at which the axis will come to a position, by its plan: ns of the far node's run. It looks from `from_ns` on
// until `until_ns`, or as far as the plan is promised.
//
// # Errors
// `COAXLE_NOT_THERE` if it does not come there as far as is known.
int32_t coaxle_far_axis_passage(coaxle_far_axis *axis,
                                const struct coaxle_awaited_position *awaited,
                                int64_t from_ns,
                                int64_t until_ns,
                                int64_t *at_ns);

// Forgets samples and plans: the next ones are of another run of the node. The set values go on from where they are. A latched error
// is reset.
int32_t coaxle_far_axis_restart(coaxle_far_axis *axis);

// Makes a far clock, and passes it out in `out`.
int32_t coaxle_far_clock_new(const struct coaxle_far_clock_parameters *parameters, coaxle_far_clock **out);

// Frees a far clock; `NULL` is left alone.
void coaxle_far_clock_free(coaxle_far_clock *clock);

// Takes a message of the far node. The order of arrival is the order of the calls.
int32_t coaxle_far_clock_message(coaxle_far_clock *clock, const struct coaxle_message *message);

// Takes a response that arrived at `arrived_ns` of the own clock.
int32_t coaxle_far_clock_response(coaxle_far_clock *clock,
                                  int64_t arrived_ns,
                                  const struct coaxle_time_response *response);

// Takes an exchange of a timing channel, whose response arrived at `arrived_ns`: all stamps were taken near to the wire.
int32_t coaxle_far_clock_timing_exchange(coaxle_far_clock *clock,
                                         int64_t arrived_ns,
                                         const struct coaxle_time_response *exchange);

// Takes readings of a time that both nodes have in common.
int32_t coaxle_far_clock_common_time(coaxle_far_clock *clock, const struct coaxle_common_time *readings);

// Runs the cycle whose ideal start is `now_ns` of the own clock, with all messages up to then. `out` may be `NULL`.
int32_t coaxle_far_clock_cycle(coaxle_far_clock *clock, int64_t now_ns, struct coaxle_far_time *out);

// Passes out far time at the instant `at_ns` of the own clock, extrapolated from the newest cycle.
int32_t coaxle_far_clock_time_at(coaxle_far_clock *clock, int64_t at_ns, struct coaxle_far_time *out);

// Passes out whether a request is due in the cycle that begins at `now_ns` of the own clock: other than 0 in `is_due`, then its
// number in `number`.
int32_t coaxle_far_clock_request(coaxle_far_clock *clock,
                                 int64_t now_ns,
                                 uint32_t *is_due,
                                 uint32_t *number);

// Passes out the shift in time, s, that makes message number `count` what the far node would have sent at the newest cycle.
//
// # Errors
// `COAXLE_NOT_THERE` while far time is not sure.
int32_t coaxle_far_clock_correction(coaxle_far_clock *clock,
                                    uint64_t count,
                                    double *out);

// Passes out the far cycle in relation to the own one, for a cycle lock: `count` is that of the newest message.
//
// # Errors
// `COAXLE_NOT_THERE` while far time is not sure, or is being moved: a lock goes on without a phase then.
int32_t coaxle_far_clock_phase(coaxle_far_clock *clock,
                               uint64_t count,
                               int64_t cycle_time_ns,
                               struct coaxle_far_phase *out);

// Writes a message with up to `COAXLE_MOST_PLANS` plans of one cycle into `bytes`, which has room for `capacity`, and passes out its
// `length`. The key is that of the node: `coaxle/<node>/plans`. `sender` and `epoch` are those of its frames.
//
// # Errors
// `COAXLE_REJECTED` names a plan that is no motion of its axis.
int32_t coaxle_plans_encode(coaxle_key *key,
                            uint32_t sender,
                            uint64_t epoch,
                            const struct coaxle_plan *plans,
                            size_t number,
                            uint8_t *bytes,
                            size_t capacity,
                            size_t *length);

// Reads a message of plans: up to `capacity` of its good plans; passes out their `number`, the run (`epoch`) of its sender, and how many
// were `refused` because they are no motion of their axis.
//
// # Errors
// `COAXLE_REJECTED` and the reason.
int32_t coaxle_plans_decode(coaxle_key *key,
                            const uint8_t *bytes,
                            size_t length,
                            uint64_t *epoch,
                            struct coaxle_plan *plans,
                            size_t capacity,
                            size_t *number,
                            size_t *refused);

// Makes a receiver of the text of its config (docs/REFERENCE.md). `name` stands for the file in errors.
int32_t coaxle_receiver_new(const struct coaxle_receiver_parameters *parameters,
                            const char *name,
                            const char *config,
                            coaxle_receiver **out);

// Frees a receiver; `NULL` is left alone.
void coaxle_receiver_free(coaxle_receiver *receiver);

// Passes out the key of its subscription with this number, from 0: messages under it are for `coaxle_receiver_message`. The text stays
// until the receiver is freed.
//
// # Errors
// `COAXLE_NOT_THERE` beyond the last one.
int32_t coaxle_receiver_subscription(coaxle_receiver *receiver,
                                     uint32_t number,
                                     const char **key);

// Takes a message of a subscription, which arrived at `arrived_ns` of the own clock. One that is damaged or foreign is counted and
// named in the node's signals, as it would be there.
int32_t coaxle_receiver_message(coaxle_receiver *receiver,
                                uint32_t subscription,
                                int64_t arrived_ns,
                                const uint8_t *bytes,
                                size_t length);

// Passes out when the next cycle is due, ns of the own clock: a lock of the cycle moves it.
int32_t coaxle_receiver_next_cycle(coaxle_receiver *receiver, int64_t *due_ns);

// Runs one cycle, which really began at `now_ns` of the own clock.
int32_t coaxle_receiver_cycle(coaxle_receiver *receiver, int64_t now_ns);

// Writes the next message of the newest cycle, which leaves at `now_ns` of the own clock, into `bytes`, and passes out its key and its
// `length`: 0 if none is left.
//
// # Errors
// `COAXLE_CAPACITY` if it does not fit: it is the next one again.
int32_t coaxle_receiver_send(coaxle_receiver *receiver,
                             int64_t now_ns,
                             const char **key,
                             uint8_t *bytes,
                             size_t capacity,
                             size_t *length);

// Passes out the number of a far axis by its name, `<node>.<axis id>`, or the one of its config.
//
// # Errors
// `COAXLE_NOT_THERE`, and the names that there are.
int32_t coaxle_receiver_find_axis(coaxle_receiver *receiver, const char *name, uint32_t *number);

// Passes out the number of a slave by its name.
//
// # Errors
// `COAXLE_NOT_THERE`, and the names that there are.
int32_t coaxle_receiver_find_slave(coaxle_receiver *receiver, const char *name, uint32_t *number);

// Passes out a far axis of the newest cycle, as its slaves follow it. Its state word says whether its clock is known (operational) and
// whether it is in error.
//
// # Errors
// `COAXLE_NOT_THERE` while nothing has been received of it.
int32_t coaxle_receiver_axis(coaxle_receiver *receiver,
                             uint32_t number,
                             struct coaxle_axis *out);

// Passes out set values and state of a slave in the newest cycle.
//
// # Errors
// `COAXLE_NOT_THERE` beyond the last slave, and while it has no set values.
int32_t coaxle_receiver_slave(coaxle_receiver *receiver, uint32_t number, struct coaxle_slave_state *out);

// Executes a command of a slave, beside those of its program. It takes effect with the next cycle. Passes out the number of its job;
// `job` may be `NULL`.
//
// # Errors
// The NC code of the refusal; the slave is unchanged then.
int32_t coaxle_receiver_execute(coaxle_receiver *receiver,
                                uint32_t slave,
                                const struct coaxle_command *command,
                                uint32_t *job);

// Takes the actual values of the caller's drive of a slave, for the next cycle.
int32_t coaxle_receiver_report_actual(coaxle_receiver *receiver, uint32_t slave, const struct coaxle_actual *actual);

// Writes the health of the node as one word into `word`, which has room for `capacity` bytes and is ended by a 0: `ok`, or the fault.
int32_t coaxle_receiver_health(coaxle_receiver *receiver,
                               char *word,
                               size_t capacity);

// Makes a slave axis without power, at its drive's position, 0.
int32_t coaxle_slave_new(const struct coaxle_slave_parameters *parameters, coaxle_slave **out);

// Frees a slave axis; `NULL` is left alone.
void coaxle_slave_free(coaxle_slave *slave);

// Runs one cycle, `elapsed_s` after the one before, with `number` masters (0 to 4). `tables` is `NULL` for an axis without cam plates,
// otherwise always the same. `out` may be `NULL`.
int32_t coaxle_slave_update(coaxle_slave *slave,
                            coaxle_tables *tables,
                            const struct coaxle_master *masters,
                            size_t number,
                            double elapsed_s,
                            struct coaxle_slave_state *out);

// Passes out set values and state as of the newest cycle.
int32_t coaxle_slave_read(coaxle_slave *slave, struct coaxle_slave_state *out);

// Plans a command without executing it: 0 if it would be accepted now, otherwise why not.
int32_t coaxle_slave_plan(coaxle_slave *slave, coaxle_tables *tables, const struct coaxle_command *command);

// Executes a command, which takes effect with the next cycle. Passes out the number of its job, 0 for one that is done at once; `job`
// may be `NULL`.
//
// # Errors
// The NC code of the refusal; the axis is unchanged then.
int32_t coaxle_slave_execute(coaxle_slave *slave,
                             coaxle_tables *tables,
                             const struct coaxle_command *command,
                             uint32_t *job);

// Passes out the state of a job, `COAXLE_JOB_NONE` to `COAXLE_JOB_FAILED`, and for a failed one its NC code in `error`, which may be
// `NULL`. The newest 16 jobs are known.
int32_t coaxle_slave_job(coaxle_slave *slave,
                         uint32_t job,
                         uint32_t *state,
                         uint32_t *error);

// Takes the actual values of the caller's drive, for the next cycle.
int32_t coaxle_slave_report_actual(coaxle_slave *slave, const struct coaxle_actual *actual);

// Passes out the axis structure as it is published in frames, with this axis id.
int32_t coaxle_slave_axis_struct(coaxle_slave *slave, coaxle_tables *tables, uint32_t axis_id, struct coaxle_axis *out);

// Passes out the 31 characteristic values of the current or last flying saw (`MC_ReadFlyingSawCharacteristics`), in the order of
// `MC_FlyingSawCharacValues` (TS5055 12.3.2). `values` has 31 places.
//
// # Errors
// `COAXLE_NOT_THERE` if there was none.
int32_t coaxle_slave_saw_characteristics(coaxle_slave *slave,
                                         double *values);

// Makes a store for up to `capacity` plates, 1 to 255.
int32_t coaxle_tables_new(uint32_t capacity, coaxle_tables **out);

// Frees a store, which no axis uses any more; `NULL` is left alone.
void coaxle_tables_free(coaxle_tables *tables);

// Adds a plate of points, in the order of their indices from 1. `is_cyclic` is other than 0 for one that repeats. Allocates.
int32_t coaxle_tables_add_points(coaxle_tables *tables,
                                 uint32_t table,
                                 uint32_t is_cyclic,
                                 const struct coaxle_motion_point *points,
                                 size_t number);

// Adds the plate of a cam file's text. `name` stands for the file in errors; files that it names are read from the folder of `name`.
// Allocates.
int32_t coaxle_tables_add_file(coaxle_tables *tables,
                               uint32_t table,
                               const char *name,
                               const char *contents);

// Removes a plate that no axis is on. Frees memory.
int32_t coaxle_tables_remove(coaxle_tables *tables, uint32_t table);

// Passes out the slave of a plate at the position `master`: position (u), velocity (u/x), acceleration (u/x²) and jerk (u/x³) in
// `motion`, which has four places.
int32_t coaxle_tables_at(coaxle_tables *tables,
                         uint32_t table,
                         double master,
                         double *motion);

// Writes the request number `number` of the run `run`, which leaves `send_stamp_ns` after the ideal start of the cycle that began at
// `ideal_start_ns` of the own clock. The key is that of the responder: `coaxle/<node>/time-requests`.
int32_t coaxle_time_request_encode(coaxle_key *key,
                                   uint32_t requester,
                                   uint64_t run,
                                   uint32_t number,
                                   int64_t ideal_start_ns,
                                   int64_t send_stamp_ns,
                                   uint8_t *bytes,
                                   size_t capacity,
                                   size_t *length);

// Reads a request. Its arrival is left to the caller.
//
// # Errors
// `COAXLE_REJECTED` and the reason.
int32_t coaxle_time_request_decode(coaxle_key *key,
                                   const uint8_t *bytes,
                                   size_t length,
                                   struct coaxle_time_request *out);

// Writes the responses to `number` requests, 16 at most. `header` is that of a frame of the same cycle, its departure that of the
// responses. The key is `coaxle/<node>/time-responses`.
int32_t coaxle_time_responses_encode(coaxle_key *key,
                                     const struct coaxle_frame_header *header,
                                     const struct coaxle_time_request *requests,
                                     size_t number,
                                     uint8_t *bytes,
                                     size_t capacity,
                                     size_t *length);

// Reads the responses of `sender` to requests of `requester`: up to `capacity`, and passes out how many there are in `number`, which
// may be more.
//
// # Errors
// `COAXLE_REJECTED` and the reason.
int32_t coaxle_time_responses_decode(coaxle_key *key,
                                     const uint8_t *bytes,
                                     size_t length,
                                     uint32_t sender,
                                     uint32_t requester,
                                     struct coaxle_time_response *responses,
                                     size_t capacity,
                                     size_t *number);

// Passes out the id of a node by its name: 1 to 64 letters, digits, `-`, `_` or `.`.
int32_t coaxle_sender_id(const char *name, uint32_t *id);

// Makes what the messages under a key need.
int32_t coaxle_key_new(const char *key, coaxle_key **out);

// Frees it; `NULL` is left alone.
void coaxle_key_free(coaxle_key *key);

// Writes a frame of `number` axes into `bytes`, which has room for `capacity`, and passes out its `length`.
int32_t coaxle_frame_encode(coaxle_key *key,
                            const struct coaxle_frame_header *header,
                            const struct coaxle_axis *axes,
                            size_t number,
                            uint8_t *bytes,
                            size_t capacity,
                            size_t *length);

// Reads a frame: its header, and up to `capacity` of its axes; passes out how many it has in `number`, which may be more.
//
// # Errors
// `COAXLE_REJECTED` and the reason. The axes are void then.
int32_t coaxle_frame_decode(coaxle_key *key,
                            const uint8_t *bytes,
                            size_t length,
                            struct coaxle_frame_header *header,
                            struct coaxle_axis *axes,
                            size_t capacity,
                            size_t *number);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* COAXLE_H */
