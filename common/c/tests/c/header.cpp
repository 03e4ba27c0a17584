// The interface from C++: a handle in a smart pointer, a command, a refusal.
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "coaxle.h"

struct Free {
  void operator()(coaxle_slave *slave) const { coaxle_slave_free(slave); }
};

int main() {
  coaxle_slave_parameters parameters{};
  parameters.struct_size = sizeof parameters;
  parameters.cycle_time_ns = 1000000;
  parameters.velocity = 100.0;
  parameters.acceleration = 1000.0;
  parameters.jerk = 10000.0;
  coaxle_slave *made = nullptr;
  if (coaxle_slave_new(&parameters, &made) != COAXLE_OK) return 1;
  const std::unique_ptr<coaxle_slave, Free> slave(made);

  coaxle_command command{};
  command.struct_size = sizeof command;
  coaxle_command_init(&command, COAXLE_POWER_ON);
  if (coaxle_slave_execute(slave.get(), nullptr, &command, nullptr) != COAXLE_OK) return 2;
  coaxle_slave_state state{};
  state.struct_size = sizeof state;
  coaxle_slave_update(slave.get(), nullptr, nullptr, 0, 0.001, nullptr);
  coaxle_command_init(&command, COAXLE_MOVE_ABSOLUTE);
  command.position = 20.0;
  std::uint32_t job = 0, is = COAXLE_JOB_NONE;
  if (coaxle_slave_execute(slave.get(), nullptr, &command, &job) != COAXLE_OK) return 3;
  for (int n = 0; n < 10000 && is != COAXLE_JOB_DONE; n++) {
    coaxle_slave_update(slave.get(), nullptr, nullptr, 0, 0.001, &state);
    coaxle_slave_job(slave.get(), job, &is, nullptr);
  }
  // Without a master there is nothing to couple to.
  coaxle_command_init(&command, COAXLE_GEAR_IN);
  const std::int32_t refused = coaxle_slave_execute(slave.get(), nullptr, &command, nullptr);
  const std::string sentence = coaxle_last_error(slave.get());
  std::printf("%f, %x, %s\n", state.position, static_cast<unsigned>(refused), sentence.c_str());
  return state.position == 20.0 && refused > 0 && sentence.find("master") != std::string::npos ? 0 : 4;
}
