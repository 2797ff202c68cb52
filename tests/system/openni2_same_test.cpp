// SPDX-License-Identifier: MIT
// A sequence gives the same results, to the byte, whether it is replayed, played by an OpenNI2 camera or read
// from OpenNI2's own recording of that camera.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "drivers/openni2/openni2_source.hpp"
#include "drivers/replay/image_file.hpp"
#include "tests/support/sequence_writer.hpp"
#include "tests/system/openni2_runs.hpp"

namespace loopsift::test {
namespace {

constexpr int kFrames = 40;

class OpenNi2Same : public OpenNi2Runs {
 protected:
  void run(const std::string& source, const std::string& out, int exit_code) const {
    std::vector<std::string> settings = {"run.rate=max", "openni2.host_time=false", "source.retry_limit=0"};
    if (!camera_file_.empty()) settings.push_back("camera.file=" + camera_file_);
    const Outcome ran = run_program(command(source, out, settings));
    ASSERT_EQ(ran.exit_code, exit_code) << ran.output;
  }
  void replay() const { run("replay:tum:" + sequence(), "replayed", 0); }

  /// The camera goes with its film, and is so lost at the end. It does not wait for its reader: where that
  /// had no processor for a whole frame, the camera is played once more, slowly.
  void play() {
    camera_.control.unplug_at_end = true;
    for (const double rate_hz : {25.0, 5.0, 1.0}) {
      camera_.control.rate_hz = rate_hz;
      camera_.apply();
      std::filesystem::remove_all(camera_.folder() / "played");
      run("openni2:", "played", 5);
      const nlohmann::json frames = report("played")["frames"];
      if (frames["received"] == kFrames && frames["dropped"] == 0) return;
    }
  }

  /// OpenNI2's recording of the film. What reads it here is of no use.
  [[nodiscard]] std::string record() {
    SourceOptions options;
    options.camera = recorded_.camera;
    options.openni2.record_path = camera_.folder() / "film.oni";
    camera_.control.unplug_at_end = true;
    camera_.apply();
    const auto live = open_openni2("", options);
    EXPECT_TRUE(live.ok()) << (live.ok() ? "" : live.error().message);
    if (!live.ok()) return "";
    FrameBuffers buffers((*live)->info());
    while ((*live)->read(buffers.frame, 100) != ReadStatus::kLost) {
    }
    return options.openni2.record_path;
  }

  void expect_same(const std::string& other) const {
    for (const char* file : {"trajectory.txt", "trajectory_odometry.txt", "map.ply", "posegraph.g2o"}) {
      EXPECT_TRUE(result("replayed", file) == result(other, file)) << file << " differs";
    }
    EXPECT_EQ(count(result(other, "trajectory.txt"), "\n"), static_cast<std::size_t>(kFrames));
  }

  std::string camera_file_;  // none, when empty
};

TEST_F(OpenNi2Same, TheCameraAsReplay) {
  make_sequence(kFrames);
  load_film(kFrames);
  replay();
  play();
  expect_same("played");
}

// What OpenNI2 2.2 does not record as it is: depth beyond what the camera says that it measures at most, and
// the end of an image whose last pixel differs from equal ones before it. A Kinect's images end in a strip
// without depth.
class OpenNi2Recorded : public OpenNi2Same {
 protected:
  void blank_the_last_pixels() const {
    for (const auto& file : std::filesystem::directory_iterator(sequence() + "/depth")) {
      DepthImage image(160, 120);
      ImageReader reader({160, 120}, {0, 0});
      ASSERT_EQ(reader.read_depth(file.path(), image.view()), nullptr) << file.path();
      std::fill(image.pixels.end() - 8, image.pixels.end(), std::uint16_t{0});
      write_depth(file.path(), image);
    }
  }
};

TEST_F(OpenNi2Recorded, TheRecordingAsReplay) {
  make_sequence(kFrames);
  blank_the_last_pixels();
  load_film(kFrames);
  replay();
  run("openni2:" + record(), "from_file", 0);
  expect_same("from_file");
}

TEST_F(OpenNi2Recorded, DamagedInsideItIsLostAndWhatCameBeforeIsWritten) {
  make_sequence(kFrames);
  load_film(kFrames);
  const std::string recording = record();
  std::string bytes = read_file(recording);
  for (std::size_t k = bytes.size() / 4; k < bytes.size() * 3 / 8; ++k) bytes[k] = static_cast<char>(7 * k);
  run("openni2:" + camera_.folder().write("damaged.oni", bytes), "damaged", 5);
  const nlohmann::json frames = report("damaged")["frames"];
  EXPECT_GT(frames["tracked"], kFrames / 4);
  EXPECT_LT(frames["tracked"], kFrames);
  EXPECT_EQ(count(result("damaged", "trajectory.txt"), "\n"), frames["tracked"]);
}

class OpenNi2Kitchen : public OpenNi2Recorded {
 protected:
  void SetUp() override {
    OpenNi2Recorded::SetUp();
    if (IsSkipped()) return;
    const char* data = std::getenv("LOOPSIFT_DATA");
    if (data == nullptr) GTEST_SKIP() << "LOOPSIFT_DATA is not set";
    link_kitchen(std::string(data) + "/redkitchen");
    load_film(kFrames);
  }
  /// The recording as a TUM sequence, at times that OpenNI2 can hold.
  void link_kitchen(const std::string& kitchen) const {
    std::filesystem::create_directory(sequence());
    for (const char* link : {"/depth", "/rgb"})
      std::filesystem::create_directory_symlink(kitchen, sequence() + link);
    std::filesystem::copy_file(kitchen + "/camera.txt", sequence() + "/camera.txt");
    std::ofstream list(sequence() + "/associations.txt");
    for (int k = 0; k < kFrames; ++k) {
      char line[160];
      std::snprintf(line, sizeof line, "%.2f depth/frame-%06d.depth.png %.2f rgb/frame-%06d.color.jpg\n",
                    0.04 * k, k, 0.04 * k, k);
      list << line;
    }
  }
};

TEST_F(OpenNi2Kitchen, TheCameraAsReplay) {
  replay();
  play();
  expect_same("played");
}

TEST_F(OpenNi2Kitchen, TheCameraAsReplayWithColourRegisteredByItsCameraFile) {
  replay();
  const std::string as_delivered = result("replayed", "map.ply");
  camera_file_ = LOOPSIFT_CONFIG_DIR "/cameras/kinect_v1.toml";
  replay();
  play();
  expect_same("played");
  EXPECT_FALSE(result("replayed", "map.ply") == as_delivered) << "the camera file changed nothing";
}

TEST_F(OpenNi2Kitchen, TheRecordingAsReplay) {
  replay();
  run("openni2:" + record(), "from_file", 0);
  expect_same("from_file");
}

}  // namespace
}  // namespace loopsift::test
