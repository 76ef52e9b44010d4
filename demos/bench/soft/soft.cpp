// qc-bench soft: soft bodies by this library beside Bullet alone, in difficult scenes: a cloth over a pile of moving
// meshes, bodies that are tangled at the start, a rope over a cylinder.
#include "bench/soft/demo_table.h"
#include "bench/soft/model.h"
#include "bench/soft/pile_scene.h"
#include "bench/soft/rope_scene.h"
#include "bench/soft/tangle_scene.h"

#include "common/files.h"
#include "common/interrupt.h"
#include "common/stopwatch.h"
#include "common/options.h"
#include "common/output_file.h"
#include "bench/bench.h"

#include <cmath>
#include <cstdio>
#include <string>

namespace
{
constexpr int s_pileSteps = 120, s_tangleSteps = 80, s_ringSteps = 30;

struct Options
{
    const char* out = "out/bench";
    bool demosOnly = false;
    uint32_t demoSteps = 240;
};

/// One measure of a scene, by this library and by Bullet. NaN: none.
struct Row
{
    const char* scene;
    const char* figure;
    double ours, bullets;
};

using Rows = std::vector<Row>;

/// Sums the time of steps.
class StepTime
{
  public:
    template <typename Scene> void Step(Scene& scene)
    {
        double start = qcStopwatch_NowMs();
        scene.Step();
        m_sum += qcStopwatch_NowMs() - start;
        m_count++;
    }
    double Mean() const
    {
        return m_sum / m_count;
    }

  private:
    double m_sum = 0;
    int m_count = 0;
};

void MakePileMesh(qcPileSceneDef* def)
{
    qcSoftModel model = qcMakeSoftModel(btScalar(0.5));
    def->positions = model.positions;
    def->indices = model.indices;
    // The scene needs the centre of mass at the origin. qcMeshShape::makeRecentered rounds differently in the last bit.
    btTransform frame = qcMeshShape(def->positions.data(), qcBulletPositions, 0, uint32_t(def->positions.size() / 3),
                                    def->indices.data(), uint32_t(def->indices.size() / 3))
                            .getMassProperties()
                            .principalFrame.inverse();
    for (size_t i = 0; i < def->positions.size(); i += 3)
    {
        btVector3 p = frame * btVector3(def->positions[i], def->positions[i + 1], def->positions[i + 2]);
        std::copy_n(&p[0], 3, &def->positions[i]);
    }
}

void MeasurePile(Rows* rows)
{
    const char* name = "a cloth of 50 x 50 nodes over 20 moving meshes, 120 steps";
    double figures[2][5];
    for (int ours = 0; ours < 2; ours++)
    {
        qcPileSceneDef def;
        def.ours = ours;
        def.nodes = 50;
        MakePileMesh(&def);
        qcPileScene scene(def);
        StepTime time;
        int still = 0;
        for (int step = 0; step < s_pileSteps && qcInterrupt_Signal() == 0; step++)
        {
            time.Step(scene);
            still = std::max(still, scene.Measure().still);
        }
        qcPileMeasure end = scene.Measure();
        double penetrating = NAN;
        if (def.ours)
            penetrating = scene.quick.getStatistics().remaining;
        const double mine[] = {double(end.height), double(end.speed), double(still), penetrating, time.Mean()};
        std::copy_n(mine, 5, figures[ours]);
    }
    rows->push_back({name, "mean height of the cloth at the end, m", figures[1][0], figures[0][0]});
    rows->push_back({name, "its mean speed then, m/s", figures[1][1], figures[0][1]});
    rows->push_back({name, "nodes that stand still in a step, most", figures[1][2], figures[0][2]});
    rows->push_back({name, "pairs that penetrate at the end", figures[1][3], figures[0][3]});
    rows->push_back({name, "a step, ms", figures[1][4], figures[0][4]});
}

void MeasureScrambled(Rows* rows)
{
    const char* name = "an elastic cube whose nodes are scrambled";
    double figures[2][5];
    for (int ours = 0; ours < 2; ours++)
    {
        qcScrambledScene scene(ours);
        StepTime time;
        figures[ours][0] = double(scene.CountTangled());
        int last = 0;
        for (int step = 1; step <= s_tangleSteps && qcInterrupt_Signal() == 0; step++)
        {
            time.Step(scene);
            size_t tangled = scene.CountTangled();
            last = tangled > 0 ? step : last;
            if (step == 16 || step == 32)
                figures[ours][step / 16] = double(tangled);
        }
        figures[ours][3] = last < s_tangleSteps ? double(last) : NAN;
        figures[ours][4] = time.Mean();
    }
    const char* const labels[] = {"pairs that penetrate at the start", "after 16 steps", "after 32 steps",
                                  "steps until none does", "a step, ms"};
    for (int i = 0; i < 5; i++)
        rows->push_back({name, labels[i], figures[1][i], figures[0][i]});
}

void MeasureRings(Rows* rows)
{
    const char* name = "three soft rings in free fall that begin inside of each other";
    double figures[2][4];
    for (int ours = 0; ours < 2; ours++)
    {
        qcRingsScene scene(ours);
        StepTime time;
        double start = double(scene.Height());
        figures[ours][0] = double(scene.CountTangled());
        int last = 0;
        for (int step = 1; step <= s_ringSteps && qcInterrupt_Signal() == 0; step++)
        {
            time.Step(scene);
            last = scene.CountTangled() > 0 ? step : last;
        }
        figures[ours][1] = last < s_ringSteps ? double(last) : NAN;
        figures[ours][2] = start - double(scene.Height());
        figures[ours][3] = time.Mean();
    }
    const char* const labels[] = {"pairs that penetrate at the start", "steps until none does",
                                  "fallen after 30 steps, m (free fall: 1.292)", "a step, ms"};
    for (int i = 0; i < 4; i++)
        rows->push_back({name, labels[i], figures[1][i], figures[0][i]});
}

void MeasureRopes(Rows* rows)
{
    static const char* const labels[] = {"8 sides, dropped: seconds until it is off", "the same, thrown along the axis",
                                         "32 sides, dropped", "the same, thrown along the axis"};
    const char* name = "a rope of 41 nodes at 2 m/s on a mesh cylinder, 20 s";
    for (int scene = 0; scene < 4; scene++)
    {
        double seconds[2];
        for (int ours = 0; ours < 2; ours++)
        {
            qcRopeSceneDef def;
            def.contact = ours ? qcRopeContact::ours : qcRopeContact::bulletsMesh;
            def.radius = btScalar(0.1);
            def.length = 4;
            def.sides = scene < 2 ? 8 : 32;
            def.velocity = scene % 2 == 0 ? btVector3(0, -2, 0) : btVector3(0, 0, 2);
            qcRopeScene rope(def);
            int step = 0;
            for (; step < 1200 && rope.Measure().highest > 0 && qcInterrupt_Signal() == 0; step++)
                rope.Step();
            seconds[ours] = step < 1200 ? step / 60.0 : NAN;
        }
        rows->push_back({name, labels[scene], seconds[1], seconds[0]});
    }
}

void PrintRows(const Rows& rows)
{
    const char* scene = "";
    for (const Row& row : rows)
    {
        if (row.scene != scene)
            std::printf("\n%s\n%-50s %12s %12s\n", row.scene, "", "ours", "Bullet");
        scene = row.scene;
        char texts[2][16];
        for (int side = 0; side < 2; side++)
        {
            double value = side == 0 ? row.ours : row.bullets;
            std::snprintf(texts[side], sizeof texts[side], std::isnan(value) ? "-" : "%.4g", value);
        }
        std::printf("  %-48s %12s %12s\n", row.figure, texts[0], texts[1]);
    }
    std::fflush(stdout);
}

bool WriteRows(const Options& options, const Rows& rows, qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(options.out, "soft.csv", &output, message))
        return false;
    std::fputs("scene,figure,ours,bullet\n", output.stream);
    for (const Row& row : rows)
    {
        qcFiles_WriteQuoted(output.stream, row.scene);
        std::fputc(',', output.stream);
        qcFiles_WriteQuoted(output.stream, row.figure);
        std::fprintf(output.stream, ",%.6g,%.6g\n", row.ours, row.bullets);
    }
    return qcOutput_Commit(&output, message);
}

bool RunHardScenes(const Options& options, qcMessage* message)
{
    Rows all;
    for (void (*measure)(Rows*) : {MeasurePile, MeasureScrambled, MeasureRings, MeasureRopes})
    {
        Rows rows;
        measure(&rows);
        // What was cut short has no figures to compare.
        if (qcInterrupt_Signal() != 0)
            break;
        PrintRows(rows);
        all.insert(all.end(), rows.begin(), rows.end());
    }
    std::printf("\n-: not counted, or never within the steps\n");
    return WriteRows(options, all, message);
}
} // namespace

extern "C" qcExitStatus qcBench_RunSoft(int argumentCount, char** arguments)
{
    static const char help[] =
        "Scenes that are hard for soft bodies, by this library and by Bullet alone: a cloth that falls over a pile of "
        "moving meshes (btGImpactMeshShape in Bullet), bodies that are tangled at the start, and a rope that is thrown "
        "over a cylinder of triangles. Then small scenes like those of Bullet's SoftDemo, step by step in turn: the "
        "cost of a "
        "step beside Bullet's, with all promises of this library and with Bullet's own.\vExit status: as for qc-bench.";
    Options options;
    const qcOption table[] = {{0, "out", "FOLDER",
                               "Where soft.csv and soft_demos.csv go; %s by default, made if it is missing",
                               qcOption_Folder(&options.out)},
                              {0, "demos", nullptr, "Only the small scenes", qcOption_Flag(&options.demosOnly, true)},
                              {0, "steps", "N", "Steps of each of the small scenes; %s by default",
                               qcOption_Number(&options.demoSteps, 1, 100000)},
                              {}};
    qcCommandLine line = {table, help, nullptr, nullptr, 0, nullptr, nullptr};
    qcCommandLine_Parse(&line, argumentCount, arguments);
    qcMessage message;
    qcInterrupt_Watch();
    if ((!options.demosOnly && !qcFiles_Check(options.out, "soft.csv", &message)) ||
        !qcFiles_Check(options.out, "soft_demos.csv", &message))
    {
        std::fprintf(stderr, "%s: %s\n", arguments[0], message.text);
        return qc_exitFailed;
    }
    bool written = options.demosOnly || RunHardScenes(options, &message);
    if (written && (qcInterrupt_Signal() != 0 || qcDemoTable_Run(options.out, options.demoSteps, &message)))
        return qcInterrupt_ExitStatus();
    std::fprintf(stderr, "%s: %s\n", arguments[0], message.text);
    return qc_exitFailed;
}
