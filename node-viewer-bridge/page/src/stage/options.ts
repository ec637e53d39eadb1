// What a person wants to see on the stage.

export interface StageOptions {
  trails: boolean;
  sigma: boolean;
  pictures: boolean;
  labels: boolean;
}
