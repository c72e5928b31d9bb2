// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// BOP's other layouts: several sensors in a scene, files image by image, archives of them; cameras
// as they are stated since 2024.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "eval/datasets/bop/mask_runs.h"
#include "eval/datasets/bop/read.h"
#include "eval/datasets/pictures.h"
#include "eval/datasets/set_frame.h"
#include "eval/datasets/sightings.h"
#include "scenes/picture/picture_file.h"
#include "scenes/target/target.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kWide = 64, kHigh = 48;

class OtherLayouts : public testing::Test {
 protected:
  void write(const std::string& name, const json& content) const {
    write_text(name, content.dump());
  }
  void write_text(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_.path() / name).parent_path());
    folder_.write(name, text);
  }
  void write_picture(const std::string& name, int width = kWide) const {
    write_text(name, png_bytes(cv::Mat(kHigh, width, CV_8U, cv::Scalar(9))));
  }
  static json truth(double z_mm = 10'000) {
    return {
        {{"obj_id", 1}, {"cam_R_m2c", {1, 0, 0, 0, 1, 0, 0, 0, 1}}, {"cam_t_m2c", {0, 0, z_mm}}}};
  }
  static json camera(double f = 500) { return {{"cam_K", {f, 0, 32, 0, f, 24, 0, 0, 1}}}; }

  // A scene with one image, of a sensor of that name, which is at another distance in each.
  void write_scene(const std::string& sensor, const std::string& pictures, double z_mm) const {
    write("test/000001/scene_gt_" + sensor + ".json", {{"0", truth(z_mm)}});
    write("test/000001/scene_gt_info_" + sensor + ".json", {{"0", {{{"visib_fract", 0.5}}}}});
    write("test/000001/scene_camera_" + sensor + ".json", {{"0", camera()}});
    write_picture("test/000001/" + pictures + "/000000.png");
  }

  // Two images side by side, the first with a mask whose left half is seen.
  void write_imagewise(const std::string& split) const {
    for (const std::string key : {"000001_000000", "000001_000012"}) {
      const std::string name = split + key;
      write(name + ".gt.json", truth());
      write(name + ".camera.json", camera());
      write_picture(name + ".rgb.png");
    }
    write(split + "000001_000000.mask_visib.json",
          {{"0", {{"size", {kHigh, kWide}}, {"counts", {0, 24 * kWide, 24 * kWide}}}}});
  }

  BopImages images() const { return read_bop_images(folder_.path(), ""); }
  std::string error() const {
    return error_of([this] { images(); });
  }

  TemporaryFolder folder_;
};

TEST_F(OtherLayouts, OfSeveralSensorsAreThatWhichBopEvaluates) {
  write_scene("cam1", "rgb_cam1", 9000);
  EXPECT_EQ(images().images[0].instances[0].cam_from_model.translation.z(), 9000);
  EXPECT_EQ(images().images[0].instances[0].visible_fraction, 0.5);
  EXPECT_EQ(bop_picture(images().images[0]), folder_.path() / "test/000001/rgb_cam1/000000.png");
  EXPECT_THAT(images().notes, IsEmpty());
  write_scene("photoneo", "gray_photoneo", 8000);
  EXPECT_EQ(images().images[0].instances[0].cam_from_model.translation.z(), 8000);
  EXPECT_THAT(images().notes,
              ElementsAre(HasSubstr("that of scene_gt_photoneo.json is read, not cam1")));
  write_scene("rgb", "rgb", 7000);  // as HOT3D has it
  EXPECT_EQ(bop_picture(images().images[0]), folder_.path() / "test/000001/rgb/000000.png");
  write("test/000001/scene_gt.json", {{"0", truth(6000)}});
  write("test/000001/scene_camera.json", {{"0", camera()}});
  EXPECT_EQ(images().images[0].instances[0].cam_from_model.translation.z(), 6000);
  fs::remove(folder_.path() / "test/000001/scene_gt.json");
  fs::remove(folder_.path() / "test/000001/scene_camera_rgb.json");
  EXPECT_THAT(error(), HasSubstr("scene_camera_rgb.json: is missing"));
}

TEST_F(OtherLayouts, OfSeveralSensorsCanBeChosen) {
  write_scene("cam1", "rgb_cam1", 9000);
  write_scene("photoneo", "gray_photoneo", 8000);
  const auto z_mm = [&](const std::string& sensor) {
    const BopImages read = read_bop_images(folder_.path(), "", sensor);
    EXPECT_THAT(read.notes.empty(), !sensor.empty()) << "what was chosen needs no note";
    return read.images.at(0).instances[0].cam_from_model.translation.z();
  };
  const auto error_with = [&](const std::string& sensor) {
    return error_of([&] { read_bop_images(folder_.path(), "", sensor); });
  };
  EXPECT_EQ(z_mm(""), 8000);
  EXPECT_EQ(z_mm("cam1"), 9000);
  EXPECT_EQ(z_mm("photoneo"), 8000);
  EXPECT_THAT(images().notes, ElementsAre(HasSubstr("not cam1: --sensor chooses")));
  EXPECT_THAT(error_with("cam2"), AllOf(HasSubstr("test/000001: has no sensor 'cam2'"),
                                        HasSubstr("its sensors are cam1, photoneo")));
  EXPECT_THAT(error_with("../000001"), HasSubstr("has no sensor"));
  // scene_gt.json beside them is a sensor without a name, read where none is chosen.
  write("test/000001/scene_gt.json", {{"0", truth(6000)}});
  write("test/000001/scene_camera.json", {{"0", camera()}});
  EXPECT_EQ(z_mm(""), 6000);
  EXPECT_EQ(z_mm("cam1"), 9000);
  EXPECT_THAT(images().notes, ElementsAre(HasSubstr("that of scene_gt.json is read, not cam1, "
                                                    "photoneo")));
  for (const char* of : {"cam1", "photoneo"}) {
    fs::remove(folder_.path() / (std::string("test/000001/scene_gt_") + of + ".json"));
  }
  EXPECT_THAT(images().notes, IsEmpty());
  EXPECT_THAT(error_with("cam1"), HasSubstr("none of another sensor: leave --sensor out"));
}

TEST_F(OtherLayouts, OfFilesImageByImageHaveNoSensors) {
  write_imagewise("test/");
  EXPECT_EQ(error(), "");
  EXPECT_THAT(error_of([&] { read_bop_images(folder_.path(), "", "cam1"); }),
              HasSubstr("no --sensor can be chosen"));
}

TEST_F(OtherLayouts, OfFilesImageByImageAreReadWithTheirMasks) {
  write_imagewise("test_imagewise/");
  const auto target = load_target("cube");
  SightingSource source;
  source.folder = folder_.path();
  const SightedSet set = read_sightings(source, target);
  ASSERT_EQ(set.sightings.size(), 2u);
  EXPECT_EQ(set.sightings[1].scene_id, 1);
  EXPECT_EQ(set.sightings[1].im_id, 12);
  EXPECT_EQ(set.sightings[0].image, "test_imagewise/000001_000000.rgb.png");
  EXPECT_TRUE(has_picture(set.sightings, 1, 12));
  EXPECT_FALSE(has_picture(set.sightings, 1, 13));
  // Of images in which the target is not to be seen the pictures alone tell, however they write it.
  write_picture("test_imagewise/1_13.rgb.png");
  EXPECT_TRUE(has_picture(set.sightings, 1, 13));
  const auto right_half_is_hidden = [&](const Sighting& sighting) {
    const SetFrame frame = read_set_frame(target, 8, sighting);
    EXPECT_FALSE(frame.problem);
    const cv::Mat bodies = frame.frame.body_ids;
    EXPECT_GT(cv::countNonZero(bodies.colRange(0, kWide / 2) == 1), 0);
    return cv::countNonZero(bodies.colRange(kWide / 2 + 3, kWide) == 1) == 0;
  };
  EXPECT_TRUE(right_half_is_hidden(set.sightings[0]));
  EXPECT_FALSE(right_half_is_hidden(set.sightings[1]));
  write_text("test_imagewise/000001_000000.mask_visib.json", "[1");
  EXPECT_EQ(read_set_frame(target, 8, set.sightings[0]).problem, EstimateOutcome::kMaskUnreadable);
}

TEST_F(OtherLayouts, OfFilesImageByImageMayLieInTheSetsFolder) {
  write_imagewise("");
  EXPECT_EQ(images().images.size(), 2u);
  write("test_targets_bop19.json", {{{"scene_id", 1}, {"im_id", 12}, {"obj_id", 1}}});
  ASSERT_EQ(images().images.size(), 1u);
  EXPECT_EQ(images().images[0].im_id, 12);
}

// As `gunzip --keep` leaves them.
TEST_F(OtherLayouts, OfFilesImageByImageMayLiePackedBesideThemselves) {
  write_imagewise("test_imagewise/");
  write_text("test_imagewise/000001_000012.gt.json.gz", "not looked at");
  EXPECT_EQ(images().images.size(), 2u);
}

TEST_F(OtherLayouts, OfFilesImageByImageSayWhatIsWrong) {
  write_imagewise("test/");
  EXPECT_EQ(error(), "");
  fs::remove(folder_.path() / "test/000001_000012.camera.json");
  EXPECT_THAT(error(), HasSubstr("test/000001_000012.camera.json: is missing"));
  write("test/000001_000012.cam.json", camera());
  EXPECT_EQ(error(), "");
  write("test/1_12.gt.json", truth());
  EXPECT_THAT(error(), HasSubstr("test: has scene 1 image 12 twice"));
  fs::remove(folder_.path() / "test/1_12.gt.json");
  write("test/left.gt.json", truth());
  EXPECT_THAT(error(), HasSubstr("left.gt.json: its name must begin with the numbers"));
}

TEST_F(OtherLayouts, OfArchivesAreNamedWithWhatToDo) {
  write_text("shard-000000.tar", "");
  const auto names_format = AllOf(HasSubstr("webdataset format"), HasSubstr("tar -xf"));
  EXPECT_THAT(error(), names_format);
  fs::create_directories(folder_.path() / "test");
  fs::rename(folder_.path() / "shard-000000.tar", folder_.path() / "test/shard-000000.tar");
  EXPECT_THAT(error(), names_format);
}

// The instances of an image lie one behind the other, and share its picture and its masks.
TEST_F(OtherLayouts, OfFilesImageByImageAreReadOnceAnImage) {
  write_imagewise("");
  const auto target = load_target("cube");
  SightingSource source;
  source.folder = folder_.path();
  const std::vector<Sighting> sightings = read_sightings(source, target).sightings;
  SetFiles files;
  const Sighting& first = sightings.at(0);
  const SetFrame before = read_set_frame(target, 8, first, files);
  ASSERT_FALSE(before.problem);
  fs::remove(first.picture);
  fs::remove(first.visible_mask);
  const SetFrame again = read_set_frame(target, 8, first, files);
  ASSERT_FALSE(again.problem);
  EXPECT_EQ(cv::norm(again.frame.image, before.frame.image, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(again.frame.body_ids, before.frame.body_ids, cv::NORM_INF), 0);
  // Whoever draws into one leaves the next as it is.
  cv::Mat drawn_into = again.frame.image;
  drawn_into.setTo(200);
  EXPECT_EQ(read_set_frame(target, 8, first, files).frame.image.at<uint8_t>(0, 0), 9);
  EXPECT_FALSE(read_set_frame(target, 8, sightings.at(1), files).problem);
  EXPECT_EQ(read_set_frame(target, 8, first, files).problem, EstimateOutcome::kPictureUnreadable)
      << "that of the last image alone is kept";
}

TEST(LinksOfASet, AreSaidWhereTheyLeadOutOfIt) {
  const TemporaryFolder folder;
  const fs::path set = folder.path() / "set", outside = folder.path() / "outside";
  for (const fs::path& made : {set / "rgb", set / "store", outside}) fs::create_directories(made);
  folder.write("set/rgb/0.png", "");
  folder.write("set/store/1", "");
  folder.write("outside/2.png", "");
  fs::create_symlink("../store/1", set / "rgb/1.png");
  const std::vector<fs::path> own = {set / "rgb/0.png", set / "rgb/1.png", set / "rgb/none.png"};
  EXPECT_EQ(note_on_links(set, own), "");
  fs::create_directory_symlink(set, folder.path() / "link");
  EXPECT_EQ(note_on_links(folder.path() / "link", {{folder.path() / "link/rgb/0.png"}}), "")
      << "the set itself may be behind one";

  fs::create_symlink(outside / "2.png", set / "rgb/2.png");
  std::vector<fs::path> with_others = own;
  with_others.push_back(set / "rgb/2.png");
  EXPECT_THAT(note_on_links(set, with_others),
              HasSubstr("set: a picture lies behind links out of the set, the first of which is " +
                        fs::canonical(outside / "2.png").string()));
  fs::create_directory_symlink(outside, set / "gray");
  with_others.push_back(set / "gray/2.png");
  EXPECT_THAT(note_on_links(set, with_others), HasSubstr("2 pictures lie behind links out of"));
}

TEST_F(OtherLayouts, OfPicturesElsewhereAreReadWithALineThatSaysSo) {
  write_imagewise("");
  const fs::path set = folder_.path() / "set";
  fs::create_directory(set);
  for (const auto& entry : fs::directory_iterator(folder_.path())) {
    if (entry.is_regular_file()) fs::create_symlink(entry.path(), set / entry.path().filename());
  }
  SightingSource source;
  source.folder = set;
  const SightedSet seen = read_sightings(source, load_target("cube"));
  EXPECT_THAT(seen.notes, testing::Contains(HasSubstr("behind links out of the set")));
  source.folder = folder_.path();
  EXPECT_THAT(read_sightings(source, load_target("cube")).notes, testing::IsEmpty());
}

TEST(MaskRuns, AreColumnByColumn) {
  const TemporaryFolder folder;
  const auto mask = [&](const std::string& entry, int gt_id = 3) {
    return MaskRuns(folder.write("m.json", R"({"3": )" + entry + "}")).mask(gt_id);
  };
  const cv::Mat read = mask(R"({"size": [2, 3], "counts": [1, 2, 3]})");
  ASSERT_EQ(read.size(), cv::Size(3, 2));
  const cv::Mat expected = (cv::Mat_<uint8_t>(2, 3) << 0, 255, 0, 255, 0, 0);
  EXPECT_EQ(cv::countNonZero(read != expected), 0);
  // As COCO's API packs 1, 2, 3 and 6, 40, 2, 12, 1000: three as they are, then -28 and 998.
  EXPECT_EQ(cv::countNonZero(mask(R"({"size": [2, 3], "counts": "123"})") != expected), 0);
  const std::string size = R"({"size": [53, 20], "counts": )";
  const cv::Mat long_runs = mask(size + R"("6X12TOVo0"})");
  ASSERT_EQ(long_runs.size(), cv::Size(20, 53));
  EXPECT_EQ(cv::countNonZero(long_runs != mask(size + "[6, 40, 2, 12, 1000]}")), 0);
  EXPECT_TRUE(MaskRuns(folder.path() / "m.json").mask(0).empty());
  for (const char* bad :
       {R"({"size": [2, 3], "counts": [1, 2, 2]})", R"({"size": [2, 3], "counts": [1, 2, 4]})",
        R"({"size": [2, 3], "counts": [-1, 7]})", R"({"size": [2, 3], "counts": "PYQ"})",
        R"({"size": [2, 3], "counts": "12"})", R"({"size": [2, 3], "counts": "1 23"})",
        R"({"size": [2, 3], "counts": "1oooooooooooooooo0"})",
        R"({"size": [90000, 90000], "counts": [8100000000]})", R"({"size": [2], "counts": []})",
        R"({"size": [2, 3], "counts": [18446744073709551615, 7]})"}) {
    EXPECT_TRUE(mask(bad).empty()) << bad;
    const std::string neighbour = R"(, "04": {"size": [1, 1], "counts": [1]})";
    EXPECT_EQ(mask(bad + neighbour, 4).total(), 1u) << "beside " << bad;
  }
}

TEST_F(OtherLayouts, HaveCamerasAsTheyAreStatedSince2024) {
  write("test/000001/scene_gt.json", {{"0", truth()}});
  write_picture("test/000001/gray/000000.png");
  const auto with_model = [&](const std::string& type, const std::vector<double>& params) {
    write(
        "test/000001/scene_camera.json",
        {{"0", {{"cam_model", {{"projection_model_type", type}, {"projection_params", params}}}}}});
  };
  with_model("CameraModelType.LINEAR", {500, 510, 32, 24});
  EXPECT_EQ(images().images[0].k(1, 1), 510);
  EXPECT_EQ(images().images[0].k(1, 2), 24);
  with_model("KANNALA_BRANDT_K3", {500, 32, 24, 0.1, 0.2, 0.3, 0.4});
  EXPECT_EQ(images().images[0].k(1, 1), 500);
  EXPECT_EQ(std::get<KannalaBrandt>(images().images[0].lens).k4, 0.4);
  EXPECT_THAT(error_of([&] { read_bop_dataset(folder_.path(), ""); }),
              HasSubstr("its cam_model has a lens, must be a pinhole"));
  with_model("FISHEYE624", {500, 32, 24});
  EXPECT_THAT(error(), HasSubstr("its cam_model is FISHEYE624, must be a pinhole or"));
  with_model("PINHOLE", {500, 32});
  EXPECT_THAT(error(), HasSubstr("projection_params has 2 numbers, must have 4"));
}

TEST_F(OtherLayouts, SayThatALensOfTheWholeSetIsNotUsed) {
  write("test/000001/scene_gt.json", {{"0", truth()}});
  write("test/000001/scene_camera.json", {{"0", camera()}});
  write("camera.json", {{"width", kWide}});
  EXPECT_THAT(images().notes, IsEmpty());
  write("camera.json", {{"width", kWide}, {"dist_coeffs", {0.1, 0, 0, 0}}});
  EXPECT_THAT(images().notes, ElementsAre(HasSubstr("camera.json: its dist_coeffs is not used")));
}

}  // namespace
}  // namespace sightline
