// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/mesh_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cstdlib>
#include <map>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "common/error.h"

namespace arpent::sim {
namespace {

namespace fs = std::filesystem;

fs::path find_mesh(const std::string& file) {
  if (fs::path(file).is_absolute()) return file;
  const char* data = std::getenv("ARPENT_DATA");
  if (data == nullptr || *data == '\0') {
    throw InputError("mesh " + file + ": is test data; set ARPENT_DATA to the folder that holds worlds/" + file);
  }
  return fs::path(data) / "worlds" / file;
}

MeshPicture read_picture(const fs::path& file) {
  const cv::Mat1b image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  if (image.empty()) throw InputError(file.string() + ": cannot be read as a picture");
  MeshPicture picture{image.cols, image.rows, {}};
  for (int v = 0; v < image.rows; ++v)
    picture.values.insert(picture.values.end(), image.ptr(v), image.ptr(v) + image.cols);
  return picture;
}

/// Picture and reflectance of each material.
struct Material {
  int picture = -1;
  float reflectance = 0.5F;
};

std::vector<Material> read_materials(const aiScene& scene, const fs::path& folder, MeshData& data) {
  std::vector<Material> materials(scene.mNumMaterials);
  std::map<std::string, int> pictures;
  for (unsigned i = 0; i < scene.mNumMaterials; ++i) {
    aiColor3D colour(0.5F, 0.5F, 0.5F);
    scene.mMaterials[i]->Get(AI_MATKEY_COLOR_DIFFUSE, colour);
    aiString own_name;
    scene.mMaterials[i]->Get(AI_MATKEY_NAME, own_name);
    // A file without materials: what the world's texture says.
    if (std::string(own_name.C_Str()) == AI_DEFAULT_MATERIAL_NAME) colour = aiColor3D(1, 1, 1);
    materials[i].reflectance = 0.299F * colour.r + 0.587F * colour.g + 0.114F * colour.b;
    aiString name;
    if (scene.mMaterials[i]->GetTexture(aiTextureType_DIFFUSE, 0, &name) != aiReturn_SUCCESS) continue;
    const auto [entry, fresh] = pictures.emplace(name.C_Str(), static_cast<int>(data.pictures.size()));
    if (fresh) data.pictures.push_back(read_picture(folder / name.C_Str()));
    materials[i].picture = entry->second;
  }
  return materials;
}

struct Triangle {
  std::array<Eigen::Vector3f, 3> p;
  std::array<Eigen::Vector2f, 3> uv;
  Material material;
};

std::vector<Triangle> read_triangles(const aiScene& scene, const std::vector<Material>& materials) {
  std::vector<Triangle> triangles;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      if (mesh.mFaces[f].mNumIndices != 3) continue;
      Triangle triangle{{}, {}, materials.at(mesh.mMaterialIndex)};
      for (std::size_t k = 0; k < 3; ++k) {
        const unsigned i = mesh.mFaces[f].mIndices[k];
        triangle.p[k] = Eigen::Vector3f(mesh.mVertices[i].x, mesh.mVertices[i].y, mesh.mVertices[i].z);
        if (mesh.HasTextureCoords(0)) {
          triangle.uv[k] = Eigen::Vector2f(mesh.mTextureCoords[0][i].x, mesh.mTextureCoords[0][i].y);
        } else {
          triangle.uv[k].setZero();
        }
      }
      if (!mesh.HasTextureCoords(0)) triangle.material.picture = -1;
      triangles.push_back(triangle);
    }
  }
  return triangles;
}

using Key = std::array<std::array<std::int64_t, 3>, 3>;

/// The same for twins, whatever their corners' order.
Key key_of(const Triangle& triangle) {
  Key key;
  for (std::size_t k = 0; k < 3; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      key[k][static_cast<std::size_t>(axis)] = std::llround(1e4 * static_cast<double>(triangle.p[k][axis]));
    }
  }
  std::sort(key.begin(), key.end());
  return key;
}

/// SketchUp writes both sides of a face: without this half of each wall shows its plain side.
void drop_twins(std::vector<Triangle>& triangles) {
  std::map<Key, std::size_t> seen;
  std::vector<Triangle> kept;
  for (const Triangle& triangle : triangles) {
    const auto [entry, fresh] = seen.emplace(key_of(triangle), kept.size());
    if (fresh) {
      kept.push_back(triangle);
    } else if (kept[entry->second].material.picture < 0 && triangle.material.picture >= 0) {
      kept[entry->second] = triangle;
    }
  }
  triangles = std::move(kept);
}

}  // namespace

std::shared_ptr<const MeshData> load_mesh(const MeshShape& shape) {
  const fs::path file = find_mesh(shape.file);
  if (!fs::is_regular_file(file)) throw InputError("mesh " + file.string() + ": is not there");
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_PreTransformVertices | aiProcess_SortByPType);
  if (scene == nullptr) throw InputError("mesh " + file.string() + ": " + importer.GetErrorString());
  auto data = std::make_shared<MeshData>();
  const auto materials = read_materials(*scene, file.parent_path(), *data);
  std::vector<Triangle> triangles = read_triangles(*scene, materials);
  // assimp turns COLLADA to y up, and nothing else.
  const Eigen::AngleAxisd upright(file.extension() == ".dae" ? 0.5 * std::numbers::pi : 0, Eigen::Vector3d::UnitX());
  const Eigen::AngleAxisd yaw(shape.yaw_rad, Eigen::Vector3d::UnitZ());
  for (Triangle& triangle : triangles) {
    for (Eigen::Vector3f& p : triangle.p) {
      p = (yaw * (upright * (shape.scale * p.cast<double>())) + shape.translation_m).cast<float>();
      if (!p.allFinite()) throw InputError("mesh " + file.string() + ": a vertex is not finite");
    }
  }
  drop_twins(triangles);
  for (const Triangle& triangle : triangles) {
    if ((triangle.p[1] - triangle.p[0]).cross(triangle.p[2] - triangle.p[0]).norm() < 1e-9F) continue;
    const auto first = static_cast<std::uint32_t>(data->mesh.vertices_m.size());
    data->mesh.vertices_m.insert(data->mesh.vertices_m.end(), triangle.p.begin(), triangle.p.end());
    data->mesh.triangles.push_back({first, first + 1, first + 2});
    data->picture_uv.push_back(triangle.uv);
    data->picture_of_triangle.push_back(triangle.material.picture);
    data->reflectance_of_triangle.push_back(triangle.material.reflectance);
  }
  if (data->mesh.triangles.empty()) throw InputError("mesh " + file.string() + ": has no triangles");
  return data;
}

}  // namespace arpent::sim
