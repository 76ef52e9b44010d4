// The film of `qc-bench through`.
//
// A recorded film is text: a line a step, three letters a coordinate, node by node, body by body. Lines that begin with
// '#' are comments. A coordinate has 18 bits over -4 .. 4 m: 0.03 mm.
#include "bench/through/film.h"

#include "bench/through/scenes.h"
#include "common/bullet/demo_picture.h"
#include "common/files.h"
#include "common/interrupt.h"
#include "film_script.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace
{
constexpr int s_hz = 60, s_steps = 24;
constexpr uint32_t s_halfWidth = 640, s_height = 560;
constexpr double s_halfRange = 4;
constexpr int s_levels = 1 << 18;

const char s_letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Positions of all nodes, three numbers each, at the start and after each step.
using Film = std::vector<std::vector<float>>;

struct Topology
{
    std::vector<uint32_t> indices[2]; ///< of the fixed and of the thrown cloth, in the positions of both
};

std::vector<float> PositionsOf(const qcThroughWorld& world)
{
    std::vector<float> positions;
    for (const qcThroughBody& body : world.Bodies())
        for (int i = 0; i < body.soft->m_nodes.size(); i++)
            for (int axis = 0; axis < 3; axis++)
                positions.push_back(float(body.soft->m_nodes[i].m_x[axis]));
    return positions;
}

Film Simulate(Topology* topology)
{
    const qcThroughScene& scene = qcThroughFilmScene();
    qcThroughWorldDef def;
    def.gravity = scene.gravity;
    def.hz = s_hz;
    qcThroughWorld world(def);
    qcJitter jitter(0);
    scene.build(&world, &jitter, scene.speed);
    uint32_t first = 0;
    for (size_t body = 0; body < 2; body++)
    {
        for (uint32_t index : world.Bodies()[body].triangles.indices)
            topology->indices[body].push_back(first + index);
        first += uint32_t(world.Bodies()[body].soft->m_nodes.size());
    }
    Film film = {PositionsOf(world)};
    for (int step = 0; step < s_steps; step++)
    {
        world.Step();
        film.push_back(PositionsOf(world));
    }
    return film;
}

std::string Encode(const std::vector<float>& positions)
{
    std::string text;
    for (float x : positions)
    {
        double part = (double(x) + s_halfRange) / (2 * s_halfRange);
        int level = std::min(std::max(int(std::lround(part * s_levels)), 0), s_levels - 1);
        text += {s_letters[level >> 12], s_letters[level >> 6 & 63], s_letters[level & 63]};
    }
    return text;
}

std::vector<float> Decode(const char* text, size_t length)
{
    std::vector<float> positions;
    for (size_t i = 0; i + 2 < length; i += 3)
    {
        int level = 0;
        for (size_t k = 0; k < 3; k++)
            level = level << 6 | int(std::strchr(s_letters, text[i + k]) - s_letters);
        positions.push_back(float(double(level) / s_levels * 2 * s_halfRange - s_halfRange));
    }
    return positions;
}

/// The film of version 0.2.0.
Film ReadBefore()
{
    Film film;
    for (const char* line = s_filmScript; *line != 0;)
    {
        size_t length = std::strcspn(line, "\n");
        if (line[0] != '#' && length > 0)
            film.push_back(Decode(line, length));
        line += length + (line[length] == '\n');
    }
    return film;
}

/// Positions at a picture's time: straight lines from the start of its step to the end.
std::vector<float> PictureAt(const Film& film, size_t picture, size_t picturesPerStep)
{
    size_t step = picture / picturesPerStep;
    float t = float(picture % picturesPerStep) / float(picturesPerStep);
    std::vector<float> positions = film[step];
    for (size_t i = 0; t > 0 && i < positions.size(); i++)
        positions[i] += t * (film[step + 1][i] - positions[i]);
    return positions;
}

bool Draw(qcDevice* device, const std::vector<float>& positions, const Topology& topology, uint32_t left,
          std::vector<uint8_t>* image, std::string* message)
{
    qcPictureMesh meshes[] = {qcPlainMesh(positions, topology.indices[0], 0.10f, 0.28f, 0.55f),
                              qcPlainMesh(positions, topology.indices[1], 0.70f, 0.42f, 0.16f)};
    for (qcPictureMesh& mesh : meshes)
        mesh.wireframe = true;
    qcPictureDef def = qcDefaultPictureDef();
    def.width = s_halfWidth;
    def.height = s_height;
    qcSet3(def.eye, 2.2f, 1.5f, 3.2f);
    qcSet3(def.target, 0.0f, -0.35f, 0.0f);
    def.fieldOfView = 38.0f;
    def.meshes = meshes;
    def.meshCount = 2;
    return qcDrawInto(device, def, image, 2 * s_halfWidth, left, message);
}

bool DrawAll(qcDevice* device, const char* folder, size_t picturesPerStep, size_t* pictures, std::string* message)
{
    Topology topology;
    Film now = Simulate(&topology), before = ReadBefore();
    if (before.size() != now.size() || before[0].size() != now[0].size())
    {
        *message = "before_film.txt has another scene";
        return false;
    }
    std::vector<uint8_t> image;
    size_t& picture = *pictures;
    for (picture = 0; picture <= s_steps * picturesPerStep && qcInterrupt_Signal() == 0; picture++)
    {
        char name[32];
        std::snprintf(name, sizeof name, "/frame_%04zu.png", picture);
        if (!Draw(device, PictureAt(before, picture, picturesPerStep), topology, 0, &image, message) ||
            !Draw(device, PictureAt(now, picture, picturesPerStep), topology, s_halfWidth, &image, message) ||
            !qcWritePng(std::string(folder) + name, image, 2 * s_halfWidth, s_height, message))
            return false;
    }
    return true;
}
} // namespace

qcExitStatus qcDrawThroughFilm(const char* folder, int picturesPerStep, size_t* pictures, qcMessage* message)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    qcDevice* device = nullptr;
    if (!qcFiles_MakeFolder(folder, message))
        return qc_exitFailed;
    qcDeviceInfo info{};
    if (qcDevice_Create(&def, &device) == qc_statusOk)
        qcDevice_GetInfo(device, &info);
    if (info.kind == qc_deviceNone || device == nullptr)
    {
        qcDevice_Destroy(device);
        qcMessage_Fail(message, "no film: nothing here draws");
        return qc_exitDevice;
    }
    std::string reason;
    bool drawn = DrawAll(device, folder, size_t(picturesPerStep), pictures, &reason);
    qcDevice_Destroy(device);
    if (drawn)
        return qc_exitDone;
    qcMessage_Fail(message, "no film: %s", reason.c_str());
    return qc_exitFailed;
}

bool qcRecordThroughFilm(const char* path, qcMessage* message)
{
    qcOutput output;
    if (!qcOutput_Open(path, &output, message))
        return false;
    Topology topology;
    for (const std::vector<float>& positions : Simulate(&topology))
        std::fprintf(output.stream, "%s\n", Encode(positions).c_str());
    return qcOutput_Commit(&output, message);
}
