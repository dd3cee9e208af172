// SPDX-License-Identifier: Apache-2.0
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/core.h>

#include <assimp/Importer.hpp>
#include <span>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/formats.hpp"

namespace haptogram {
namespace {

Vec3 from_assimp(const aiVector3D& v) {
    return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

std::span<aiMesh* const> meshes(const aiScene& scene) { return {scene.mMeshes, scene.mNumMeshes}; }
std::span<const aiFace> faces(const aiMesh& mesh) { return {mesh.mFaces, mesh.mNumFaces}; }
std::span<const aiVector3D> vertices(const aiMesh& mesh) { return {mesh.mVertices, mesh.mNumVertices}; }

struct Totals {
    std::size_t points = 0;
    std::size_t faces = 0;
    double area = 0.0;
};

/// Areas by the vector area, which is that of any flat polygon that does not cross itself.
Totals totals(const aiScene& scene) {
    Totals sum;
    for (const aiMesh* mesh : meshes(scene)) {
        sum.points += mesh->mNumVertices;
        sum.faces += mesh->mNumFaces;
        for (const aiFace& face : faces(*mesh)) {
            const auto corner = [&](unsigned k) { return from_assimp(mesh->mVertices[face.mIndices[k]]); };
            Vec3 twice{};
            for (unsigned k = 2; k < face.mNumIndices; ++k)
                twice = twice + cross(corner(k - 1) - corner(0), corner(k) - corner(0));
            sum.area += 0.5 * norm(twice);
        }
    }
    return sum;
}

Cloud as_cloud(const aiScene& scene) {
    Cloud cloud;
    for (const aiMesh* mesh : meshes(scene))
        for (const aiVector3D& vertex : vertices(*mesh)) cloud.points.push_back(from_assimp(vertex));
    return cloud;
}

Mesh as_mesh(const aiScene& scene) {
    Mesh joined;
    for (const aiMesh* mesh : meshes(scene)) {
        const auto first = static_cast<std::uint32_t>(joined.vertices.size());
        for (const aiVector3D& vertex : vertices(*mesh)) joined.vertices.push_back(from_assimp(vertex));
        for (const aiFace& face : faces(*mesh))
            joined.triangles.push_back({first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
    }
    return joined;
}

}  // namespace

Piece import_checked(const Checked& checked, const std::string& format, const std::string& file) {
    if (checked.points == 0) throw bad_input(file, "found no points, expected at least one; export the shape again");
    Assimp::Importer importer;
    const aiScene* scene =
        importer.ReadFileFromMemory(checked.content.data(), checked.content.size(), 0, format.c_str());
    if (scene == nullptr)
        throw bad_input(file, fmt::format("cannot be read: {}; export the shape again", importer.GetErrorString()));
    for (const aiMesh* mesh : meshes(*scene))
        for (const aiFace& face : faces(*mesh))
            for (unsigned k = 0; k < face.mNumIndices; ++k)
                if (face.mIndices[k] >= mesh->mNumVertices)
                    throw bad_input(file,
                                    fmt::format("the importer library found the corner {} of {} vertices; export the "
                                                "shape in another format",
                                                face.mIndices[k], mesh->mNumVertices));
    const Totals found = totals(*scene);
    if (found.faces != checked.faces || (checked.faces == 0 && found.points != checked.points))
        throw bad_input(
            file,
            fmt::format("the importer library found {} points and {} faces, expected {} and {}; export the shape in "
                        "another format",
                        found.points, found.faces, checked.points, checked.faces));
    if (checked.faces == 0) return as_cloud(*scene);
    if (found.area == 0.0)
        throw bad_input(
            file,
            fmt::format(
                "all {} faces together have zero area, expected a surface; export the shape as points or with faces "
                "that are not flat to a line",
                found.faces));
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
    if (scene == nullptr || totals(*scene).area < (1.0 - 1e-6) * found.area)
        throw bad_input(file,
                        "holds polygons that cannot be cut into triangles, because they cross themselves; export the "
                        "shape as triangles");
    return as_mesh(*scene);
}

}  // namespace haptogram
