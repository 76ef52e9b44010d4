// Changes of a scene that must not change its pairs: after names are mapped back, the changed scene has the pairs,
// relations, distances and contacts of the original by brute force, whatever method, device, threads, image or history
// found them.
#include "support/devices.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>
#include <stdio.h>

enum
{
    qc_maxParts = 8,
    qc_seedCount = 10
};

/// Distances differ by no more, in units of a model, whose points are at most some 10 units away.
static const double s_rounding = 1e-12;

//  ---- models ----------------------------------------------------------------------------------------------------

/// A body, and the names that its triangles have in the original.
typedef struct Part
{
    qcSoup soup;
    uint32_t* names;
    bool isSingle, deforming, mirrored; ///< how it is given; mirrored: by a transform, its positions are reflected
} Part;

typedef struct Model
{
    Part parts[qc_maxParts];
    int count;
    double unit; ///< all lengths are multiples of it or of the margin
    qcRandom random;
} Model;

static void* Allocate(size_t size)
{
    void* memory = malloc(size + 1);
    ck_assert_ptr_nonnull(memory);
    return memory;
}

/// Rounds positions to a lattice, so that moves by multiples of it are exact, and triangles touch and are coplanar.
static void Snap(qcSoup* soup, int bits)
{
    for (uint32_t i = 0; i < 3 * soup->vertexCount; i++)
        soup->positions[i] = ldexp(nearbyint(ldexp(soup->positions[i], bits)), -bits);
}

static Model MakeModel(uint64_t seed)
{
    Model model = {.count = 3, .unit = 1.0, .random = {seed}};
    int bits = seed % 2 == 0 ? 18 : 5;
    uint32_t name = 0;
    for (int i = 0; i < model.count; i++)
    {
        Part* part = &model.parts[i];
        part->soup = i == 0   ? qcSoup_MakeRandom(seed, 120, 0.3)
                     : i == 1 ? qcSoup_MakeFoldedCloth(seed, 10, 0.02, 0.03)
                              : qcSoup_MakeDegenerate(seed, 80, 0.3, 0.4);
        Snap(&part->soup, bits);
        part->names = Allocate(part->soup.triangleCount * sizeof(uint32_t));
        for (uint32_t t = 0; t < part->soup.triangleCount; t++)
            part->names[t] = name++;
    }
    return model;
}

static void Model_Free(Model* model)
{
    for (int i = 0; i < model->count; i++)
    {
        qcSoup_Free(&model->parts[i].soup);
        free(model->parts[i].names);
    }
}

/// A random order of 0 .. count - 1.
static uint32_t* Shuffle(qcRandom* random, uint32_t count)
{
    uint32_t* order = Allocate(count * sizeof *order);
    for (uint32_t i = 0; i < count; i++)
    {
        uint32_t j = qcRandom_Below(random, i + 1);
        order[i] = order[j];
        order[j] = i;
    }
    return order;
}

//  ---- changes ---------------------------------------------------------------------------------------------------

static void PermuteTriangles(Model* model)
{
    for (int i = 0; i < model->count; i++)
    {
        Part* part = &model->parts[i];
        uint32_t count = part->soup.triangleCount;
        uint32_t* order = Shuffle(&model->random, count);
        uint32_t* indices = Allocate(3 * (size_t)count * sizeof *indices);
        uint32_t* names = Allocate(count * sizeof *names);
        for (uint32_t t = 0; t < count; t++)
        {
            memcpy(indices + 3 * (size_t)t, part->soup.indices + 3 * (size_t)order[t], 3 * sizeof *indices);
            names[t] = part->names[order[t]];
        }
        free(part->soup.indices);
        free(part->names);
        free(order);
        part->soup.indices = indices;
        part->names = names;
    }
}

static void PermuteVertices(Model* model)
{
    for (int i = 0; i < model->count; i++)
    {
        qcSoup* soup = &model->parts[i].soup;
        uint32_t* order = Shuffle(&model->random, soup->vertexCount);
        double* positions = Allocate(3 * (size_t)soup->vertexCount * sizeof *positions);
        for (uint32_t v = 0; v < soup->vertexCount; v++)
            memcpy(positions + 3 * (size_t)order[v], soup->positions + 3 * (size_t)v, 3 * sizeof *positions);
        for (uint32_t k = 0; k < 3 * soup->triangleCount; k++)
            soup->indices[k] = order[soup->indices[k]];
        free(soup->positions);
        free(order);
        soup->positions = positions;
    }
}

/// Another first corner, and the other orientation, of some triangles.
static void PermuteCorners(Model* model)
{
    for (int i = 0; i < model->count; i++)
        for (uint32_t t = 0; t < model->parts[i].soup.triangleCount; t++)
        {
            uint32_t* v = model->parts[i].soup.indices + 3 * (size_t)t;
            const uint32_t old[3] = {v[0], v[1], v[2]};
            uint32_t first = qcRandom_Below(&model->random, 3), turn = 1 + qcRandom_Below(&model->random, 2);
            for (uint32_t k = 0; k < 3; k++)
                v[k] = old[(first + turn * k) % 3];
        }
}

static void PermuteBodies(Model* model)
{
    Model old = *model;
    uint32_t* order = Shuffle(&model->random, (uint32_t)model->count);
    for (int i = 0; i < model->count; i++)
        model->parts[i] = old.parts[order[i]];
    free(order);
}

static void PermuteAxes(Model* model)
{
    uint32_t first = qcRandom_Below(&model->random, 3), turn = 1 + qcRandom_Below(&model->random, 2);
    for (int i = 0; i < model->count; i++)
        for (uint32_t v = 0; v < model->parts[i].soup.vertexCount; v++)
        {
            double* p = model->parts[i].soup.positions + 3 * (size_t)v;
            const double old[3] = {p[0], p[1], p[2]};
            for (uint32_t k = 0; k < 3; k++)
                p[k] = old[(first + turn * k) % 3];
        }
}

static void Reflect(Model* model)
{
    uint32_t axes = 1 + qcRandom_Below(&model->random, 7);
    for (int i = 0; i < model->count; i++)
        for (uint32_t k = 0; k < 3 * model->parts[i].soup.vertexCount; k++)
            if ((axes >> k % 3 & 1) != 0)
                model->parts[i].soup.positions[k] *= -1.0;
}

/// Some bodies by their mirror images, which their transforms mirror back.
static void ReflectByTransform(Model* model)
{
    for (int i = 0; i < model->count; i++)
        model->parts[i].mirrored = qcRandom_Below(&model->random, 2) == 0;
}

static void ScaleBy(Model* model, int exponent)
{
    model->unit = ldexp(model->unit, exponent);
    for (int i = 0; i < model->count; i++)
        for (uint32_t k = 0; k < 3 * model->parts[i].soup.vertexCount; k++)
            model->parts[i].soup.positions[k] = ldexp(model->parts[i].soup.positions[k], exponent);
}

/// By a power of two.
static void Scale(Model* model)
{
    ScaleBy(model, (int)qcRandom_Integer(&model->random, -60, 60));
}

/// By a power of two at which products of four lengths leave the range of doubles, but no length does.
static void ScaleFar(Model* model)
{
    int exponent = (int)qcRandom_Integer(&model->random, 300, 900);
    ScaleBy(model, qcRandom_Below(&model->random, 2) == 0 ? exponent : -exponent);
}

/// By multiples of the lattice.
static void Translate(Model* model)
{
    double by[3];
    for (int k = 0; k < 3; k++)
        by[k] = qcRandom_Integer(&model->random, -(1 << 24), 1 << 24);
    for (int i = 0; i < model->count; i++)
        qcSoup_Translate(&model->parts[i].soup, by[0], by[1], by[2]);
}

/// The triangles of a part from `first` on, below `end`, with all of its vertices.
static Part CopyPart(const Part* part, uint32_t first, uint32_t end)
{
    Part copy = *part;
    copy.soup.triangleCount = end - first;
    copy.soup.positions = Allocate(3 * (size_t)part->soup.vertexCount * sizeof(double));
    memcpy(copy.soup.positions, part->soup.positions, 3 * (size_t)part->soup.vertexCount * sizeof(double));
    copy.soup.indices = Allocate(3 * (size_t)(end - first) * sizeof(uint32_t));
    memcpy(copy.soup.indices, part->soup.indices + 3 * (size_t)first, 3 * (size_t)(end - first) * sizeof(uint32_t));
    copy.names = Allocate((end - first) * sizeof(uint32_t));
    memcpy(copy.names, part->names + first, (end - first) * sizeof(uint32_t));
    return copy;
}

/// Each body becomes two.
static void SplitBodies(Model* model)
{
    for (int i = model->count; i-- > 0;)
    {
        Part whole = model->parts[i];
        uint32_t count = whole.soup.triangleCount, middle = 1 + qcRandom_Below(&model->random, count - 1);
        model->parts[i] = CopyPart(&whole, 0, middle);
        model->parts[model->count++] = CopyPart(&whole, middle, count);
        qcSoup_Free(&whole.soup);
        free(whole.names);
    }
}

/// No two triangles share a vertex index.
static void UnshareVertices(Model* model)
{
    for (int i = 0; i < model->count; i++)
    {
        qcSoup* soup = &model->parts[i].soup;
        uint32_t corners = 3 * soup->triangleCount;
        double* positions = Allocate(3 * (size_t)corners * sizeof *positions);
        for (uint32_t k = 0; k < corners; k++)
        {
            memcpy(positions + 3 * (size_t)k, soup->positions + 3 * (size_t)soup->indices[k], 3 * sizeof *positions);
            soup->indices[k] = k;
        }
        free(soup->positions);
        soup->positions = positions;
        soup->vertexCount = corners;
    }
}

/// Bodies whose vertices floats hold are given as floats, and all of them as deforming.
static void GiveOtherwise(Model* model)
{
    for (int i = 0; i < model->count; i++)
        model->parts[i].isSingle = model->parts[i].deforming = true;
}

typedef struct Change
{
    const char* name;
    void (*apply)(Model*);
    bool separatesNeighbours; ///< neighbours become triangles of different bodies, or without common vertices
} Change;

static const Change s_changes[] = {{"triangles permuted", PermuteTriangles, false},
                                   {"vertices permuted", PermuteVertices, false},
                                   {"corners permuted", PermuteCorners, false},
                                   {"bodies permuted", PermuteBodies, false},
                                   {"axes permuted", PermuteAxes, false},
                                   {"reflected", Reflect, false},
                                   {"reflected by transforms", ReflectByTransform, false},
                                   {"scaled", Scale, false},
                                   {"scaled to the ends of the range", ScaleFar, false},
                                   {"translated", Translate, false},
                                   {"given as deforming floats", GiveOtherwise, false},
                                   {"bodies split", SplitBodies, true},
                                   {"vertices unshared", UnshareVertices, true}};

enum
{
    qc_changeCount = sizeof s_changes / sizeof s_changes[0]
};

//  ---- results ---------------------------------------------------------------------------------------------------

/// Pairs by the names of their triangles, sorted.
typedef struct NamedPair
{
    uint32_t lower, upper, relation;
    double distance, depth; ///< in units of the model; 0 without qcDetectDef::proximities
} NamedPair;

typedef struct NamedPairs
{
    NamedPair* pairs;
    size_t count;
} NamedPairs;

static int CompareNamed(const void* x, const void* y)
{
    const NamedPair *a = x, *b = y;
    if (a->lower != b->lower)
        return a->lower < b->lower ? -1 : 1;
    return a->upper != b->upper ? (a->upper < b->upper ? -1 : 1) : 0;
}

static float* RoundToFloats(const double* positions, size_t count)
{
    float* floats = Allocate(count * sizeof *floats);
    for (size_t i = 0; i < count; i++)
    {
        floats[i] = (float)positions[i];
        ck_assert_double_eq((double)floats[i], positions[i]);
    }
    return floats;
}

static double* ReflectAll(const double* positions, size_t count)
{
    double* reflected = Allocate(count * sizeof *reflected);
    for (size_t i = 0; i < count; i++)
        reflected[i] = -positions[i];
    return reflected;
}

/// Slots of a new scene are the numbers of its bodies.
static void AddParts(qcScene* scene, const Model* model, qcBodyId ids[qc_maxParts])
{
    for (int i = 0; i < model->count; i++)
    {
        const Part* part = &model->parts[i];
        qcBodyDef def = qcBodyDefOf(&part->soup);
        void* given = NULL;
        if (part->mirrored)
        {
            def.positions = given = ReflectAll(part->soup.positions, 3 * (size_t)part->soup.vertexCount);
            for (int k = 0; k < 9; k += 4)
                def.transform.linear[k] = -1.0;
        }
        if (part->isSingle)
        {
            def.positions = given = RoundToFloats(part->soup.positions, 3 * (size_t)part->soup.vertexCount);
            def.positionType = qc_positionF32;
        }
        def.deforming = part->deforming;
        CHECK_OK(qcScene_AddBody(scene, &def, &ids[i]));
        free(given);
    }
}

static NamedPairs DetectNamed(qcScene* scene, const Model* model, const qcDetectDef* def)
{
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, def, &result));
    NamedPairs named = {Allocate(result->pairCount * sizeof(NamedPair)), result->pairCount};
    for (size_t i = 0; i < named.count; i++)
    {
        const qcPair* pair = &result->pairs[i];
        uint32_t a = model->parts[pair->bodyA].names[pair->triangleA];
        uint32_t b = model->parts[pair->bodyB].names[pair->triangleB];
        named.pairs[i] = (NamedPair){a < b ? a : b, a < b ? b : a, (uint32_t)pair->relation, 0.0, 0.0};
        if (result->proximities == NULL)
            continue;
        named.pairs[i].distance = result->proximities[i].distance / model->unit;
        named.pairs[i].depth = result->proximities[i].depth / model->unit;
    }
    qsort(named.pairs, named.count, sizeof(NamedPair), CompareNamed);
    return named;
}

static void CheckSameNamed(const NamedPairs* expected, const NamedPairs* found, const char* what)
{
    for (size_t i = 0; i < expected->count && i < found->count; i++)
    {
        const NamedPair *e = &expected->pairs[i], *f = &found->pairs[i];
        if (CompareNamed(e, f) != 0 || e->relation != f->relation)
            ck_abort_msg("%s: pair %zu is %u %u %s, expected %u %u %s", what, i, f->lower, f->upper,
                         qcRelation_Name((qcRelation)f->relation), e->lower, e->upper,
                         qcRelation_Name((qcRelation)e->relation));
        if (fabs(e->distance - f->distance) > s_rounding || fabs(e->depth - f->depth) > s_rounding)
            ck_abort_msg("%s: %u %u: distance %.17g, depth %.17g, expected %.17g, %.17g", what, f->lower, f->upper,
                         f->distance, f->depth, e->distance, e->depth);
    }
    ck_assert_msg(expected->count == found->count, "%s: %zu pairs, expected %zu", what, found->count, expected->count);
}

/// The request number `kind`: pairs that penetrate, that touch, with neighbours, near ones; with distances.
static qcDetectDef MakeRequest(int kind, double unit)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.touching = kind % 4 == 1 || kind % 4 == 2;
    def.neighbours = kind % 4 >= 2;
    def.margin = kind % 4 == 3 ? unit * 0x1p-6 : 0.0;
    def.proximities = true;
    return def;
}

static NamedPairs DetectByBruteForce(const Model* model, qcDetectDef def)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyId ids[qc_maxParts];
    AddParts(scene, model, ids);
    def.method = qc_methodBrute;
    NamedPairs named = DetectNamed(scene, model, &def);
    qcScene_Destroy(scene);
    return named;
}

//  ---- tests -----------------------------------------------------------------------------------------------------

/// Compares a changed model, found in some way, with the original.
static void CheckChange(uint64_t seed, const Change* change, qcDevice* device, qcMethod method)
{
    Model original = MakeModel(seed), changed = MakeModel(seed);
    change->apply(&changed);
    // Without their common vertices, neighbours are pairs like others.
    int kind = change->separatesNeighbours ? 2 + (int)(seed % 2) : (int)(seed % 4);
    qcDetectDef def = MakeRequest(kind, original.unit);
    NamedPairs expected = DetectByBruteForce(&original, def);
    ck_assert_uint_gt(expected.count, 20);
    def = MakeRequest(kind, changed.unit);
    def.method = method;
    def.threads = 1 + (uint32_t)(seed % 4);
    qcScene* scene = qcMakeScene(device);
    qcBodyId ids[qc_maxParts];
    AddParts(scene, &changed, ids);
    NamedPairs found = DetectNamed(scene, &changed, &def);
    char what[100];
    snprintf(what, sizeof what, "seed %d, %s, %s", (int)seed, change->name, qcMethod_Name(method));
    CheckSameNamed(&expected, &found, what);
    free(found.pairs);
    free(expected.pairs);
    qcScene_Destroy(scene);
    Model_Free(&changed);
    Model_Free(&original);
}

START_TEST(a_change_of_names_or_frame_changes_no_pair)
{
    for (uint64_t seed = 1; seed <= qc_seedCount; seed++)
    {
        CheckChange(seed, &s_changes[_i], NULL, qc_methodSweep);
        CheckChange(seed, &s_changes[_i], NULL, qc_methodBrute);
    }
}
END_TEST

START_TEST(a_change_of_names_or_frame_changes_no_pair_on_a_device)
{
    QC_FOR_EACH_DEVICE(device)
    {
        for (int change = 0; change < qc_changeCount; change++)
            for (uint64_t seed = 1; seed <= 4; seed++)
                CheckChange(seed, &s_changes[change], device, seed % 2 == 0 ? qc_methodAuto : qc_methodLayers);
    }
}
END_TEST

static int CompareDoubles(const void* x, const void* y)
{
    double a = *(const double*)x, b = *(const double*)y;
    return (a > b) - (a < b);
}

/// The different distances of a model's contacts, in its units, in ascending order. Two features at one place, of which
/// a contact names one, depend on the order of names, so that the number of contacts does.
static double* DetectContacts(const Model* model, qcMethod method, uint32_t threads, size_t* count)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyId ids[qc_maxParts];
    AddParts(scene, model, ids);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.threads = threads;
    def.contactMargin = model->unit * 0x1p-6;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    *count = result->contactCount;
    double* distances = Allocate(*count * sizeof *distances);
    for (size_t i = 0; i < *count; i++)
        distances[i] = result->contacts[i].distance / model->unit;
    qsort(distances, *count, sizeof *distances, CompareDoubles);
    size_t different = 0;
    for (size_t i = 0; i < *count; i++)
        if (different == 0 || distances[i] > distances[different - 1] + s_rounding)
            distances[different++] = distances[i];
    *count = different;
    qcScene_Destroy(scene);
    return distances;
}

START_TEST(a_change_of_names_or_frame_changes_no_contact)
{
    // Contacts are for lengths between 1e-70 and 1e70.
    if (s_changes[_i].apply == ScaleFar)
        return;
    for (uint64_t seed = 1; seed <= qc_seedCount; seed++)
    {
        const Change* change = &s_changes[_i];
        Model original = MakeModel(seed), changed = MakeModel(seed);
        change->apply(&changed);
        size_t count, changedCount;
        double* expected = DetectContacts(&original, qc_methodBrute, 1, &count);
        double* found = DetectContacts(&changed, qc_methodSweep, 1 + (uint32_t)(seed % 4), &changedCount);
        ck_assert_uint_gt(count, 20);
        ck_assert_msg(count == changedCount, "seed %d, %s: %zu contacts, expected %zu", (int)seed, change->name,
                      changedCount, count);
        for (size_t i = 0; i < count; i++)
            ck_assert_msg(fabs(expected[i] - found[i]) <= s_rounding, "seed %d, %s: contact %zu is at %g, expected %g",
                          (int)seed, change->name, i, found[i], expected[i]);
        free(expected);
        free(found);
        Model_Free(&changed);
        Model_Free(&original);
    }
}
END_TEST

/// Changes one after the other add up.
START_TEST(many_changes_change_no_pair)
{
    for (uint64_t seed = 1; seed <= 4 * qc_seedCount; seed++)
    {
        Model original = MakeModel(seed), changed = MakeModel(seed);
        changed.random.state += seed * 1000;
        // All but those that separate neighbours and that leave the range of floats or of the lattice.
        for (int i = 0; i < 12; i++)
            s_changes[qcRandom_Below(&changed.random, 7)].apply(&changed);
        qcDetectDef def = MakeRequest((int)(seed % 4), original.unit);
        NamedPairs expected = DetectByBruteForce(&original, def);
        qcScene* scene = qcMakeScene(NULL);
        qcBodyId ids[qc_maxParts];
        AddParts(scene, &changed, ids);
        def.method = qc_methodSweep;
        NamedPairs found = DetectNamed(scene, &changed, &def);
        CheckSameNamed(&expected, &found, "many changes");
        free(found.pairs);
        free(expected.pairs);
        qcScene_Destroy(scene);
        Model_Free(&changed);
        Model_Free(&original);
    }
}
END_TEST

/// Moves all bodies through other states, detecting in each, and back.
static void LiveAndReturn(qcScene* scene, Model* model, const qcBodyId ids[qc_maxParts], qcDetectDef def)
{
    for (int step = 0; step < 6; step++)
    {
        for (int i = 0; i < model->count; i++)
        {
            qcSoup* soup = &model->parts[i].soup;
            double* moved = Allocate(3 * (size_t)soup->vertexCount * sizeof *moved);
            double most = step % 2 == 0 ? 0.01 : 0.5;
            for (uint32_t k = 0; k < 3 * soup->vertexCount; k++)
                moved[k] =
                    step == 5 ? soup->positions[k] : soup->positions[k] + qcRandom_Uniform(&model->random, -most, most);
            CHECK_OK(qcScene_SetVertices(scene, ids[i], moved, qc_positionF64, 0));
            free(moved);
        }
        const qcResult* result;
        def.touching = step % 3 == 0;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
    }
}

static void CheckHistory(qcDevice* device, uint64_t seed, qcMethod method)
{
    Model model = MakeModel(seed);
    for (int i = 0; i < model.count; i++)
        model.parts[i].deforming = true;
    qcDetectDef def = MakeRequest((int)(seed % 4), model.unit);
    NamedPairs expected = DetectByBruteForce(&model, def);
    qcScene* scene = qcMakeScene(device);
    qcBodyId ids[qc_maxParts];
    AddParts(scene, &model, ids);
    def.method = method;
    LiveAndReturn(scene, &model, ids, def);
    NamedPairs found = DetectNamed(scene, &model, &def);
    CheckSameNamed(&expected, &found, "history");
    free(found.pairs);
    free(expected.pairs);
    qcScene_Destroy(scene);
    Model_Free(&model);
}

START_TEST(what_a_scene_was_before_changes_no_pair)
{
    for (uint64_t seed = 1; seed <= 2 * qc_seedCount; seed++)
        CheckHistory(NULL, seed, qc_methodSweep);
    QC_FOR_EACH_DEVICE(device)
    {
        for (uint64_t seed = 1; seed <= 4; seed++)
            CheckHistory(device, seed, qc_methodLayers);
    }
}
END_TEST

/// Images of any size, seen along any axis: `layers` as it is, `quick` and `cullide` with grown primitives.
START_TEST(the_view_and_the_resolution_change_no_pair)
{
    static const struct
    {
        char axis;
        uint32_t columns;
        char views[4];
        uint32_t resolution;
    } images[] = {{'x', 16, "x", 64}, {'y', 64, "zy", 200}, {'z', 256, "yxz", 33}, {0, 1024, "z", 512}};
    static const qcMethod methods[] = {qc_methodLayers, qc_methodQuick, qc_methodCullide};
    QC_FOR_EACH_DEVICE(device)
    {
        for (uint64_t seed = 1; seed <= 12; seed++)
        {
            Model model = MakeModel(seed / 3);
            qcMethod method = methods[seed % 3];
            qcDetectDef def = MakeRequest(method == qc_methodLayers ? (int)(seed / 3) % 4 : 0, model.unit);
            NamedPairs expected = DetectByBruteForce(&model, def);
            qcScene* scene = qcMakeScene(device);
            qcBodyId ids[qc_maxParts];
            AddParts(scene, &model, ids);
            for (size_t i = 0; i < sizeof images / sizeof images[0]; i++)
            {
                def.method = method;
                def.reliable = method != qc_methodLayers;
                def.layerDepthAxis = images[i].axis;
                def.layerColumns = images[i].columns;
                memcpy(def.views, images[i].views, sizeof def.views);
                def.resolution = images[i].resolution;
                NamedPairs found = DetectNamed(scene, &model, &def);
                CheckSameNamed(&expected, &found, qcMethod_Name(method));
                free(found.pairs);
            }
            free(expected.pairs);
            qcScene_Destroy(scene);
            Model_Free(&model);
        }
    }
}
END_TEST

int main(void)
{
    TCase* testCase = qcMakeCase("metamorphic");
    tcase_add_loop_test(testCase, a_change_of_names_or_frame_changes_no_pair, 0, qc_changeCount);
    tcase_add_loop_test(testCase, a_change_of_names_or_frame_changes_no_contact, 0, qc_changeCount);
    tcase_add_test(testCase, a_change_of_names_or_frame_changes_no_pair_on_a_device);
    tcase_add_test(testCase, many_changes_change_no_pair);
    tcase_add_test(testCase, what_a_scene_was_before_changes_no_pair);
    tcase_add_test(testCase, the_view_and_the_resolution_change_no_pair);
    return qcRunCase("metamorphic", testCase);
}
