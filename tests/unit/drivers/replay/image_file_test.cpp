// SPDX-License-Identifier: MIT
#include "drivers/replay/image_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/support/sequence_writer.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using test::ColorImage;
using test::DepthImage;
using test::TemporaryFolder;
using ::testing::HasSubstr;

constexpr ImageSize kSize{43, 31};

// The reference encoder, with one filter for every row. `interlaced`, `bits`: forms that we do not take.
void write_by_libpng(const std::string& path, const DepthImage& image, int filter, int bits = 16,
                     int interlace = 0) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  ASSERT_NE(file, nullptr);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), bits,
               PNG_COLOR_TYPE_GRAY, interlace, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_filter(png, 0, filter);
  png_write_info(png, info);
  if (bits == 16) png_set_swap(png);
  std::vector<png_bytep> rows;
  for (int y = 0; y < image.height; ++y) {
    rows.push_back(reinterpret_cast<png_bytep>(const_cast<std::uint16_t*>(image.view().row(y))));
  }
  png_write_image(png, rows.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

class ImageFile : public ::testing::Test {
 protected:
  const char* read_depth(const std::string& name) {
    return reader_.read_depth(folder_ / name, decoded_.view());
  }
  void flip_byte(const std::string& name, std::streamoff from_end) {
    std::fstream file(folder_ / name, std::ios::binary | std::ios::in | std::ios::out);
    file.seekg(-from_end, std::ios::end);
    const char byte = static_cast<char>(file.get() ^ 0x55);
    file.seekp(-from_end, std::ios::end);
    file.put(byte);
  }

  TemporaryFolder folder_;
  ImageReader reader_{kSize, kSize};
  DepthImage depth_ = test::make_depth(kSize.width, kSize.height, 3);
  DepthImage decoded_{kSize.width, kSize.height};
  ColorImage color_ = test::make_color(kSize.width, kSize.height, 3);
  ColorImage decoded_color_{kSize.width, kSize.height};
};

TEST_F(ImageFile, DepthFromTheReferenceEncoderWithEveryFilter) {
  for (const int filter :
       {PNG_FILTER_NONE, PNG_FILTER_SUB, PNG_FILTER_UP, PNG_FILTER_AVG, PNG_FILTER_PAETH}) {
    write_by_libpng(folder_ / "d.png", depth_, filter);
    decoded_ = DepthImage(kSize.width, kSize.height);
    ASSERT_EQ(read_depth("d.png"), nullptr) << "filter " << filter;
    EXPECT_TRUE(test::equal(decoded_.view(), depth_.view())) << "filter " << filter;
  }
}

TEST_F(ImageFile, DepthThatWeWriteIsReadByUsAndByTheReferenceDecoder) {
  test::write_depth(folder_ / "d.png", depth_);
  ASSERT_EQ(read_depth("d.png"), nullptr);
  EXPECT_TRUE(test::equal(decoded_.view(), depth_.view()));
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&png, (folder_ / "d.png").c_str()), 0);
  EXPECT_EQ(png.width, 43U);
  EXPECT_EQ(png.height, 31U);
  png.format = PNG_FORMAT_GRAY;
  std::vector<std::uint8_t> grey(43 * 31);
  EXPECT_NE(png_image_finish_read(&png, nullptr, grey.data(), 0, nullptr), 0) << png.message;
}

TEST_F(ImageFile, DepthGoesIntoAViewWithStride) {
  test::write_depth(folder_ / "d.png", depth_);
  DepthImage wide(60, kSize.height);
  const ImageView<std::uint16_t> view(wide.pixels.data(), kSize.width, kSize.height, 60);
  ASSERT_EQ(reader_.read_depth(folder_ / "d.png", view), nullptr);
  EXPECT_TRUE(test::equal(view, depth_.view()));
  EXPECT_EQ(wide.view()(kSize.width, 0), 0) << "wrote past the view's row";
}

TEST_F(ImageFile, TruncatedDepthIsRefusedAtEveryLength) {
  for (const double fraction : {0.0, 0.01, 0.05, 0.5, 0.9}) {
    test::write_depth(folder_ / "d.png", depth_);
    test::truncate_file(folder_ / "d.png", fraction);
    EXPECT_THAT(read_depth("d.png"), HasSubstr("truncated")) << "at " << fraction;
  }
}

TEST_F(ImageFile, OnlyTheEmptyEndChunkMayBeMissing) {
  test::write_depth(folder_ / "d.png", depth_);
  const auto size = std::filesystem::file_size(folder_ / "d.png");
  std::filesystem::resize_file(folder_ / "d.png", size - 12);
  ASSERT_EQ(read_depth("d.png"), nullptr);
  EXPECT_TRUE(test::equal(decoded_.view(), depth_.view()));
  std::filesystem::resize_file(folder_ / "d.png", size - 13);
  EXPECT_THAT(read_depth("d.png"), HasSubstr("truncated"));
}

TEST_F(ImageFile, DamagedDepthIsRefused) {
  test::write_depth(folder_ / "d.png", depth_);
  flip_byte("d.png", 100);
  EXPECT_STREQ(read_depth("d.png"), "the file is corrupt");
  test::write_depth(folder_ / "d.png", depth_);
  ASSERT_EQ(read_depth("d.png"), nullptr) << "a reader must recover from a bad file";
}

TEST_F(ImageFile, OtherFormsOfPngAreNoDepth) {
  write_by_libpng(folder_ / "d8.png", depth_, PNG_FILTER_NONE, 8);
  EXPECT_THAT(read_depth("d8.png"), HasSubstr("not a 16-bit grey PNG"));
  test::write_color_png(folder_ / "rgb.png", color_);
  EXPECT_THAT(read_depth("rgb.png"), HasSubstr("not a 16-bit grey PNG"));
  test::write_color_jpeg(folder_ / "c.jpg", color_);
  EXPECT_THAT(read_depth("c.jpg"), HasSubstr("not a PNG"));
  EXPECT_THAT(read_depth("none.png"), HasSubstr("does not exist"));
}

TEST_F(ImageFile, ImagesOfAnotherSizeAreRefused) {
  test::write_depth(folder_ / "d.png", test::make_depth(31, 43, 1));
  EXPECT_THAT(read_depth("d.png"), HasSubstr("another size"));
  test::write_color_png(folder_ / "c.png", test::make_color(20, 20, 1));
  EXPECT_THAT(reader_.read_color(folder_ / "c.png", decoded_color_.view()), HasSubstr("another size"));
  test::write_color_jpeg(folder_ / "c.jpg", test::make_color(20, 20, 1));
  EXPECT_THAT(reader_.read_color(folder_ / "c.jpg", decoded_color_.view()), HasSubstr("another size"));
}

TEST_F(ImageFile, AFileLargerThanItsPixelsIsRefused) {
  folder_.write("d.png", std::string(1 << 20, 'x'));
  EXPECT_THAT(read_depth("d.png"), HasSubstr("larger than an image"));
}

TEST_F(ImageFile, ColorPngIsExactAndJpegNearly) {
  test::write_color_png(folder_ / "c.png", color_);
  ASSERT_EQ(reader_.read_color(folder_ / "c.png", decoded_color_.view()), nullptr);
  EXPECT_EQ(test::largest_difference(decoded_color_.view(), color_.view()), 0);
  test::write_color_jpeg(folder_ / "c.jpg", color_);
  ASSERT_EQ(reader_.read_color(folder_ / "c.jpg", decoded_color_.view()), nullptr);
  EXPECT_LE(test::largest_difference(decoded_color_.view(), color_.view()), 12);
}

TEST_F(ImageFile, TruncatedColorIsRefused) {
  test::write_color_png(folder_ / "c.png", color_);
  test::truncate_file(folder_ / "c.png", 0.6);
  EXPECT_THAT(reader_.read_color(folder_ / "c.png", decoded_color_.view()), HasSubstr("truncated"));
  test::write_color_jpeg(folder_ / "c.jpg", color_);
  test::truncate_file(folder_ / "c.jpg", 0.8);
  EXPECT_THAT(reader_.read_color(folder_ / "c.jpg", decoded_color_.view()), HasSubstr("truncated"));
  folder_.write("c.bmp", "BM not for us");
  EXPECT_THAT(reader_.read_color(folder_ / "c.bmp", decoded_color_.view()),
              HasSubstr("neither PNG nor JPEG"));
}

TEST_F(ImageFile, SizeIsReadFromTheHead) {
  test::write_depth(folder_ / "d.png", depth_);
  test::write_color_jpeg(folder_ / "c.jpg", color_);
  for (const char* name : {"d.png", "c.jpg"}) {
    const auto size = read_image_size(folder_ / name);
    ASSERT_TRUE(size.ok()) << size.error().message;
    EXPECT_EQ(size->width, kSize.width);
    EXPECT_EQ(size->height, kSize.height);
  }
  folder_.write("x.png", "text");
  EXPECT_THAT(read_image_size(folder_ / "x.png").error().message,
              HasSubstr("x.png: is neither a PNG nor a JPEG"));
  EXPECT_EQ(read_image_size(folder_ / "none.png").error().code, ErrorCode::kNotFound);
}

TEST_F(ImageFile, AHeadThatClaimsAHugeImageIsRefused) {
  const auto huge = test::claim_jpeg_size(test::jpeg_bytes(color_), 60000, 30000);
  EXPECT_EQ(jpeg_size({huge.data(), huge.size()}).width, 0);
  folder_.write("huge.jpg", std::string(huge.begin(), huge.end()));
  EXPECT_THAT(read_image_size(folder_ / "huge.jpg").error().message, HasSubstr("at most 8192 pixels"));
}

}  // namespace
}  // namespace loopsift
