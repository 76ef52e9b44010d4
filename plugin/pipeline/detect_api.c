// Detections: at once, or begun and ended. Arguments are checked here; stages trust them.
#include "pipeline/scene_state.h"

#include "base/definition.h"
#include "base/float_mode.h"
#include "base/status.h"
#include "pipeline/calibrate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

qcStatus qcCheckPointer(const void* pointer, const char* function, const char* argument)
{
    return pointer != NULL ? qc_statusOk : qcFail(qc_statusBadInput, "%s: %s is null", function, argument);
}

qcStatus qcScene_CheckIdle(const qcScene* scene, const char* function)
{
    QC_TRY(qcCheckPointer(scene, function, "scene"));
    if (scene->pending.isPending)
        return qcFail(qc_statusBadInput,
                      "%s: the detection begun by qcScene_DetectBegin is pending; call qcScene_DetectEnd first",
                      function);
    return qc_statusOk;
}

static qcStatus CheckViews(const char views[4], const char* function)
{
    for (int i = 0; i < 4; i++)
    {
        if (views[i] == 0 && i > 0)
            return qc_statusOk;
        if (views[i] < 'x' || views[i] > 'z' || memchr(views, views[i], (size_t)i) != NULL)
            break;
    }
    return qcFail(qc_statusBadInput, "%s: views must be 1 to 3 different letters of \"xyz\"", function);
}

static qcStatus CheckMargin(double margin, const char* name, const char* function)
{
    if (!(margin >= 0.0) || isinf(margin))
        return qcFail(qc_statusBadInput, "%s: %s is %g; it must be finite and 0 or more", function, name, margin);
    return qc_statusOk;
}

static qcStatus CheckDetectDef(const qcDetectDef* def, const char* function)
{
    if ((unsigned)def->method > qc_methodLayers)
        return qcFail(qc_statusBadInput, "%s: unknown method %d", function, (int)def->method);
    if ((def->enterStage == NULL) != (def->leaveStage == NULL))
        return qcFail(qc_statusBadInput, "%s: enterStage and leaveStage go together", function);
    QC_TRY(CheckMargin(def->margin, "margin", function));
    QC_TRY(CheckMargin(def->contactMargin, "contactMargin", function));
    QC_TRY(CheckMargin(def->spacing, "spacing", function));
    if (def->layerColumns > 4096)
        return qcFail(qc_statusBadInput, "%s: layerColumns is %u; it must be within 0..4096", function,
                      def->layerColumns);
    if (def->layerDepthAxis != 0 && (def->layerDepthAxis < 'x' || def->layerDepthAxis > 'z'))
        return qcFail(qc_statusBadInput, "%s: layerDepthAxis is none of 'x', 'y', 'z' and 0", function);
    bool image = def->method == qc_methodCullide || def->method == qc_methodQuick;
    if (def->motion && image)
        return qcFail(qc_statusBadInput, "%s: %s has no motion", function, qcMethod_Name(def->method));
    if (def->motion && (def->margin > 0.0 || def->contactMargin > 0.0))
        return qcFail(qc_statusBadInput, "%s: a motion has neither margin nor contactMargin", function);
    if (def->motion && (def->segments || def->manifolds))
        return qcFail(qc_statusBadInput, "%s: a motion has neither segments nor manifolds", function);
    if (image && def->contactMargin > 0.0)
        return qcFail(qc_statusBadInput, "%s: %s culls what does not intersect, so it has no contactMargin", function,
                      qcMethod_Name(def->method));
    if (image && def->margin > 0.0 && !def->reliable)
        return qcFail(qc_statusBadInput, "%s: %s has a margin only if it is reliable", function,
                      qcMethod_Name(def->method));
    if (!image)
        return qc_statusOk;
    if (def->resolution < 1 || def->resolution > 4096)
        return qcFail(qc_statusBadInput, "%s: resolution is %u; it must be within 1..4096", function, def->resolution);
    return CheckViews(def->views, function);
}

/// Checks the arguments of both ways to detect, and fills the definition.
static qcStatus TakeDef(const qcScene* scene, const qcDetectDef* given, const char* function, qcDetectDef* def)
{
    QC_TRY(qcScene_CheckIdle(scene, function));
    QC_TRY(qcCheckPointer(given, function, "def"));
    *def = qcDefaultDetectDef();
    QC_TRY(qcDef_Take(given, QC_DEF_LAYOUT(function, qcDetectDef, method), def));
    return CheckDetectDef(def, function);
}

/// Records the definition before the step, so that a crash in it can be replayed.
static void RecordBegin(qcScene* scene, qcDetectDef* def)
{
    if (scene->recorder != NULL)
        qcSceneRecorder_BeginDetect(scene->recorder, def);
}

static void RecordEnd(qcScene* scene, qcStatus status)
{
    if (scene->recorder != NULL)
        qcSceneRecorder_EndDetect(scene->recorder, status, &scene->detector.result);
}

static qcStatus RunDetector(qcScene* scene, const qcDetectDef* def)
{
    return qcDetector_Run(def, scene->device, qcCalibrate, &scene->bodies, &scene->detector);
}

__attribute__((noinline)) static qcStatus Detect(qcScene* scene, const qcDetectDef* given, const qcResult** result)
{
    qcDetectDef def;
    QC_TRY(TakeDef(scene, given, "qcScene_Detect", &def));
    QC_TRY(qcCheckPointer(result, "qcScene_Detect", "result"));
    RecordBegin(scene, &def);
    qcStatus status = RunDetector(scene, &def);
    RecordEnd(scene, status);
    if (status == qc_statusOk)
        *result = &scene->detector.result;
    return status;
}

qcStatus qcScene_Detect(qcScene* scene, const qcDetectDef* def, const qcResult** result)
{
    qcFloatMode mode = qcFloatMode_Begin();
    qcStatus status = Detect(scene, def, result);
    qcFloatMode_End(mode);
    return status;
}

//  ---- begun and ended ---------------------------------------------------------------------------------------------

static void RunPending(void* context)
{
    qcScene* scene = context;
    qcPendingDetection* pending = &scene->pending;
    pending->status = RunDetector(scene, &pending->def);
    // Each thread has its own message.
    if (pending->status != qc_statusOk)
        snprintf(pending->message, sizeof pending->message, "%s", qcLastMessage());
}

__attribute__((noinline)) static qcStatus Begin(qcScene* scene, const qcDetectDef* given)
{
    qcDetectDef def;
    QC_TRY(TakeDef(scene, given, "qcScene_DetectBegin", &def));
    qcPendingDetection* pending = &scene->pending;
    if (pending->background == NULL)
        QC_TRY(qcBackground_Create(&pending->background));
    RecordBegin(scene, &def);
    pending->def = def;
    pending->isPending = true;
    qcBackground_Post(pending->background, RunPending, scene);
    return qc_statusOk;
}

qcStatus qcScene_DetectBegin(qcScene* scene, const qcDetectDef* def)
{
    qcFloatMode mode = qcFloatMode_Begin();
    qcStatus status = Begin(scene, def);
    qcFloatMode_End(mode);
    return status;
}

static qcStatus End(qcScene* scene)
{
    qcPendingDetection* pending = &scene->pending;
    qcBackground_Wait(pending->background);
    pending->isPending = false;
    RecordEnd(scene, pending->status);
    return pending->status == qc_statusOk ? qc_statusOk : qcFail(pending->status, "%s", pending->message);
}

qcStatus qcScene_DetectEnd(qcScene* scene, const qcResult** result)
{
    QC_TRY(qcCheckPointer(scene, "qcScene_DetectEnd", "scene"));
    QC_TRY(qcCheckPointer(result, "qcScene_DetectEnd", "result"));
    if (!scene->pending.isPending)
        return qcFail(qc_statusBadInput, "qcScene_DetectEnd: no detection is pending");
    QC_TRY(End(scene));
    *result = &scene->detector.result;
    return qc_statusOk;
}

void qcScene_DropDetection(qcScene* scene)
{
    if (scene->pending.isPending)
        (void)End(scene);
    qcBackground_Destroy(scene->pending.background);
    scene->pending.background = NULL;
}
